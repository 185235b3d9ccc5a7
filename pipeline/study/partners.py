"""Scores and transforms of the pairs of a list of shapes, each computed once, for studies of the search."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from functools import cached_property

import numpy as np

from riot.construction.plan_search import plan_pairs, refine_best, trunk_pairs
from riot.construction.plan_transform import construct_plans
from riot.errors import RiotError, TrunkError
from riot.geometry.shape import Shape
from riot.parameters import (
    QCRS_VARIANTS,
    ConstructParameters,
    CrsParameters,
    QcrsVariant,
    RefineParameters,
    TrunkParameters,
)
from riot.scores.crs import CrossSide, best_of_prepared, prepare
from riot.scores.qcrs import score_block
from riot.scores.trunk_stack import stack
from riot.scores.trunks import Trunks, compared_trunks, full_trunks
from riot.transform.deformation import overlap_ratios
from riot.transform.transform import Transform
from riot.types import FloatArray


@dataclass
class Clock:
    """CPU seconds by step."""

    seconds: dict[str, float] = field(default_factory=dict)
    last: float = field(default_factory=time.process_time)

    def tick(self, step: str) -> None:
        """Add the time since the last call to a step."""
        now = time.process_time()
        self.seconds[step] = self.seconds.get(step, 0.0) + now - self.last
        self.last = now


class StudiedPartners:
    """Shapes, by number, and what their pairs give; ``variant`` is that of QCRS."""

    def __init__(
        self,
        shapes: Sequence[Shape],
        trunks: TrunkParameters,
        refinement: RefineParameters,
        crs: CrsParameters | None = None,
        variant: QcrsVariant = "paper",
    ) -> None:
        self.shapes, self.parameters, self.refinement, self.variant = shapes, trunks, refinement, variant
        self._crs = crs
        self._sides: dict[int, CrossSide] = {}
        self._plans: dict[tuple[int, int], tuple[float, Callable[[], Transform]]] = {}
        self._transforms: dict[tuple[int, int], Transform | RiotError] = {}

    @cached_property
    def quick(self) -> list[Trunks]:
        """The trunks of every shape that QCRS compares."""
        return [compared_trunks(shape, self.variant, self.parameters) for shape in self.shapes]

    def quick_scores(self, count: int) -> FloatArray:
        """(count, shapes) QCRS of the first ``count`` with all; −1 of a shape with itself."""
        scores = score_block(stack(self.quick[:count]), stack(self.quick), QCRS_VARIANTS[self.variant]).score
        scores = scores.reshape(count, len(self.shapes)).copy()
        scores[np.arange(count), np.arange(count)] = -1.0
        return scores

    def side(self, k: int) -> CrossSide:
        """A shape with its full trunks, prepared for CRS."""
        if k not in self._sides:
            self._sides[k] = prepare(self.shapes[k], full_trunks(self.shapes[k], self.parameters))
        return self._sides[k]

    def cross(self, i: int, j: int) -> float:
        """CRS, 0 without trunks of one n."""
        best = best_of_prepared(self.side(min(i, j)), self.side(max(i, j)), self._crs)
        return best[0].score if best else 0.0

    def bound(self, i: int, j: int) -> float:
        """What the IoU of the worse shape can be on the pair's refined trunks; −1 if there are none."""
        return self._plan(min(i, j), max(i, j))[0]

    def transform(self, i: int, j: int) -> Transform | RiotError:
        """What a pair gives, or why it gives nothing."""
        key = min(i, j), max(i, j)
        if key not in self._transforms:
            self._transforms[key] = attempt(self._plan(*key)[1])
        return self._transforms[key]

    def best(self, i: int, few: Sequence[int], always: int = -1) -> dict[int, float]:
        """IoU of the worse shape of i with those that matter: those whose bound does not rule out that they are first.

        ``always`` is among them in any case. The refused are not.
        """
        ious: dict[int, float] = {}
        bounds = {j: self.bound(i, j) for j in few}
        for j in sorted(few, key=lambda j: (j != always, -bounds[j], j)):
            if ious and bounds[j] <= max(ious.values()):
                continue
            transform = self.transform(i, j)
            if isinstance(transform, Transform):
                ious[j] = min(overlap_ratios(transform))
        return ious

    def _plan(self, i: int, j: int) -> tuple[float, Callable[[], Transform]]:
        """The bound of a pair's refined trunks, and what constructs on them."""
        if (i, j) not in self._plans:
            scores = best_of_prepared(self.side(i), self.side(j), self._crs, self.refinement.candidates)
            pairs = trunk_pairs(self.shapes[i], self.shapes[j], scores, self.refinement.reach)
            planned, unplanned = plan_pairs(pairs, self.refinement)
            plans = refine_best(planned, self.refinement)

            def make() -> Transform:
                if not scores:
                    raise TrunkError("no trunks of one n")
                return construct_plans(plans, unplanned, ConstructParameters())

            self._plans[i, j] = plans[0].bound if plans else -1.0, make
        return self._plans[i, j]


def changed(settings: Sequence[str]) -> tuple[TrunkParameters, RefineParameters]:
    """The defaults with ``trunks.NAME=VALUE`` and ``refine.NAME=VALUE`` put in; ValueError if there is no such."""
    groups: dict[str, dict[str, float]] = {"trunks": asdict(TrunkParameters()), "refine": asdict(RefineParameters())}
    for setting in settings:
        path, _, value = setting.partition("=")
        group, _, name = path.partition(".")
        if group not in groups or name not in groups[group]:
            raise ValueError(f"{setting}: give trunks.NAME=VALUE or refine.NAME=VALUE, NAME as in riot.parameters")
        groups[group][name] = type(groups[group][name])(value)
    return TrunkParameters(**groups["trunks"]), RefineParameters(**groups["refine"])  # type: ignore[arg-type]


def attempt(make: Callable[[], Transform]) -> Transform | RiotError:
    """The transform, or the refusal."""
    try:
        return make()
    except RiotError as error:
        return error

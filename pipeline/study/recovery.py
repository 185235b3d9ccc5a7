"""Whether the search finds the partner of a hidden shape: what becomes of it step by step, and the shares. Ours.

Every hidden shape is scored with all others by QCRS; the best go on to CRS, the best of these to refined trunks and
construction. Ranks count against the partner where scores are equal. Shares come with 95 % Wilson intervals that take a
pair's two shapes for one trial, for they stand and fall together more often than not.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeline.study.hidden import HiddenPair, failed_test
from pipeline.study.partners import Clock, StudiedPartners, attempt
from pipeline.study.statistics import wilson
from riot.construction.trunk_choice import construct
from riot.errors import RiotError
from riot.geometry.silhouette import polygon_shape
from riot.transform.deformation import overlap_ratios
from riot.transform.transform import Transform
from riot.types import FloatArray

POLYGONS, PICTURES = 0.999, 0.985
"""IoU of the worse shape that is aimed at."""
WAYS = {
    "polygons": "polygons, trunks given",
    "pictures": "pictures, trunks given",
    "found": "pictures, trunks found",
}
QUANTILES = {"least": 0.0, "p5": 0.05, "median": 0.5, "greatest": 1.0}


@dataclass(frozen=True)
class Recovery:
    """What became of the partner of one hidden shape; ranks from 1, None where the partner did not get so far.

    ``quick_lost`` and ``full_lost`` name the test which the shape's or its partner's true trunk fails, "" if none does;
    ``first`` is the partner of highest IoU among those that were constructed.
    """

    name: str
    n: int
    topology: str
    curved: bool
    quick_rank: int
    quick_score: float
    quick_lost: str
    cross_rank: int | None
    cross_score: float
    full_lost: str
    final_rank: int | None
    first: str
    first_iou: float
    cause: str = ""


@dataclass(frozen=True)
class Closeness:
    """IoU of the worse shape of one pair, nan where construction refuses, by what was given."""

    name: str
    n: int
    polygons: float
    pictures: float
    found: float
    refusals: tuple[str, ...] = ()


class RecoverySearch:
    """A collection with the hidden shapes first: pair k's are 2k and 2k + 1."""

    def __init__(self, hidden: Sequence[HiddenPair], partners: StudiedPartners, keep: int, few: int) -> None:
        self.hidden = [side for pair in hidden for side in (pair.p, pair.q)]
        self.pairs, self.keep, self.few = hidden, keep, few
        self.partners, self.clock = partners, Clock()

    def run(self, say: Callable[[str], None]) -> list[Recovery]:
        """QCRS, CRS and construction for every hidden shape."""
        scores = self.partners.quick_scores(len(self.hidden))
        self.clock.tick("QCRS")
        recoveries = []
        for i, row in enumerate(scores):
            recoveries.append(self.follow(i, row))
            if i % 20 == 19:
                say(f"CRS and construction of {i + 1} of {len(self.hidden)} hidden shapes …")
        return recoveries

    def follow(self, i: int, quick: FloatArray) -> Recovery:
        """What becomes of the partner of hidden shape i, whose QCRS with all shapes are ``quick``."""
        mate, partners = i ^ 1, self.partners
        kept = [int(j) for j in np.argsort(-quick, kind="stable")[: self.keep] if quick[j] > 0.0]
        cross = {j: partners.cross(i, j) for j in kept}
        cross_score = partners.cross(i, mate)
        self.clock.tick("CRS")
        cross_rank = _rank(np.array([*cross.values()]), kept.index(mate)) if mate in cross else None
        few = [j for j in sorted(cross, key=lambda j: (-cross[j], j))[: self.few] if cross[j] > 0.0]
        ious = partners.best(i, few, mate)
        first = max(ious, key=lambda j: (ious[j], -j), default=-1)
        final_rank = 1 + sum(iou >= ious[mate] for j, iou in ious.items() if j != mate) if mate in ious else None
        self.clock.tick("refinement and construction")
        quick_lost = next(filter(None, (self._failed_test(k, self.partners.variant == "paper") for k in (i, mate))), "")
        full_lost = next(filter(None, (self._failed_test(k, False) for k in (i, mate))), "")
        self.clock.tick("looking for the true trunks")
        pair = self.pairs[i // 2]
        recovery = Recovery(
            name=self.hidden[i].shape.name,
            n=pair.n,
            topology=pair.topology,
            curved=pair.curved,
            quick_rank=_rank(quick, mate),
            quick_score=float(quick[mate]),
            quick_lost=quick_lost,
            cross_rank=cross_rank,
            cross_score=cross_score,
            full_lost=full_lost,
            final_rank=final_rank,
            first=partners.shapes[first].name if ious else "",
            first_iou=ious[first] if ious else math.nan,
        )
        return replace(recovery, cause=self._cause(recovery, i, few))

    def _failed_test(self, k: int, quick: bool) -> str:
        trunks = self.partners.quick[k] if quick else self.partners.side(k).trunks
        return failed_test(self.hidden[k], trunks, quick, self.partners.parameters)

    def _cause(self, recovery: Recovery, i: int, few: Sequence[int]) -> str:
        """Where the partner was lost; "" if it is first in the end."""
        if recovery.final_rank == 1:
            return ""
        if recovery.cross_rank is None:
            return f"QCRS: {recovery.quick_lost or 'others score higher'}"
        if i ^ 1 not in few:
            return f"CRS: {recovery.full_lost or 'others score higher'}"
        if recovery.final_rank is None:
            refusal = self.partners.transform(i, i ^ 1)
            return f"construction: {getattr(refusal, 'reason', 'refused')}"
        return "construction: another has a higher IoU"

    def closeness(self, number: int) -> Closeness:
        """IoU of one pair from its polygons and from its pictures on the true trunks, and as the search finds it."""
        pair = self.pairs[number]
        polygons = [polygon_shape(polygon) for polygon in (pair.exact.p, pair.exact.q)]
        moved = [polygons[0].from_source(pair.exact.trunk_p), polygons[1].from_source(pair.exact.trunk_q)]
        ways: list[Transform | RiotError] = [
            attempt(lambda: construct(polygons[0], polygons[1], trunks=(moved[0], moved[1]))),
            attempt(lambda: construct(pair.p.shape, pair.q.shape, trunks=(pair.p.corners, pair.q.corners[::-1]))),
            self.partners.transform(2 * number, 2 * number + 1),
        ]
        self.clock.tick("construction on given trunks")
        refusals = tuple("" if isinstance(result, Transform) else str(result) for result in ways)
        polygon, on_trunks, searched = (
            min(overlap_ratios(result)) if isinstance(result, Transform) else math.nan for result in ways
        )
        return Closeness(f"hidden{number:03d}", pair.n, polygon, on_trunks, searched, refusals)


def _rank(scores: FloatArray, number: int) -> int:
    return int(np.count_nonzero(scores >= scores[number]))


@dataclass(frozen=True)
class RecoveryShare:
    """A share of hidden shapes, or of pairs: ``good`` of ``of``, its interval, and what is aimed at."""

    name: str
    good: int
    of: int
    low: float
    high: float
    target: float | None
    by_n: dict[int, tuple[int, int]]

    @property
    def share(self) -> float:
        """``good`` / ``of``."""
        return self.good / self.of


def figures(recoveries: Sequence[Recovery], close: Sequence[Closeness], keep: int) -> list[RecoveryShare]:
    """All shares."""
    tests: list[tuple[str, float | None, Callable[[Recovery], bool]]] = [
        ("QCRS: a trunk near the true one, both shapes", None, lambda recovery: recovery.quick_lost == ""),
        ("QCRS: partner first", None, lambda recovery: recovery.quick_rank == 1),
        ("QCRS: among the first three", None, lambda recovery: recovery.quick_rank <= 3),
        (f"QCRS: among the first {keep}", None, lambda recovery: recovery.cross_rank is not None),
        ("CRS: a trunk near the true one, both shapes", None, lambda recovery: recovery.full_lost == ""),
        ("CRS: partner first", None, lambda recovery: recovery.cross_rank == 1),
        (
            "CRS: among the first three",
            0.9,
            lambda recovery: recovery.cross_rank is not None and recovery.cross_rank <= 3,
        ),
        ("construction: partner first by IoU", 0.95, lambda recovery: recovery.final_rank == 1),
    ]
    rows = [
        _figure(name, target, [(recovery.n, test(recovery)) for recovery in recoveries], 2)
        for name, target, test in tests
    ]
    # What ranking costs: the partner's own trunks, refined, may be better than all that got so far.
    above = [
        (recovery.n, close[k // 2].found >= recovery.first_iou or recovery.final_rank == 1)
        for k, recovery in enumerate(recoveries)
    ]
    rows.append(_figure("IoU with the partner above all constructed", None, above, 2))
    for which, words in WAYS.items():
        aim = POLYGONS if which == "polygons" else PICTURES
        results = [(recovery.n, getattr(recovery, which) >= aim) for recovery in close]
        rows.append(_figure(f"IoU ≥ {aim}: {words}", None, results, 1))
    return rows


def _figure(name: str, target: float | None, results: Sequence[tuple[int, bool]], together: int) -> RecoveryShare:
    good, total = sum(ok for _, ok in results), len(results)
    sizes = sorted({n for n, _ in results})
    by_n = {n: (sum(ok for m, ok in results if m == n), sum(m == n for m, _ in results)) for n in sizes}
    return RecoveryShare(name, good, total, *wilson(good, total, together), target, by_n)


def quantiles(close: Sequence[Closeness]) -> dict[str, dict[str, float]]:
    """IoU of the worse shape, of the pairs that were constructed."""
    rows = {}
    for which in WAYS:
        ious = np.array([getattr(closeness, which) for closeness in close])
        good = ious[~np.isnan(ious)]
        row = {word: float(np.quantile(good, q)) if len(good) else math.nan for word, q in QUANTILES.items()}
        rows[which] = {**row, "refused": float(len(ious) - len(good))}
    return rows

"""The parameters of which pairs are selected and chosen."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from pipeline.config.parsing import parse_names, parse_pieces
from riot.errors import ParameterError
from riot.parameters import ParameterGroup, parameter

BREADTH = {"varied": 20, "global": 10, "paper": 10}
"""How many times more pairs than ``top`` go on to CRS by each policy. Ours: with 20, 75 of 80 hidden pairs do."""


@dataclass(frozen=True)
class SelectConfig(ParameterGroup):
    """Which pairs go on to CRS and construction, and which are chosen (policy paper: paper §5.3; else ours)."""

    policy: Literal["varied", "global", "paper"] = parameter(
        "varied",
        source="paper: paper §5.3; varied, global: ours",
        meaning="varied: many different things, each recognised well. global: the least deformed pairs of different "
        "classes. paper: all pairs among the shapes of best reversibility, one of each class.",
    )
    top: int = parameter(100, at_least=1, meaning="Number of pairs that are chosen.")
    per_class_pair: int = parameter(3, at_least=1, meaning="Most pairs of the same two classes (policy global).")
    per_shape: int = parameter(5, at_least=1, meaning="Most pairs with the same shape (policy global).")
    breadth: int | None = parameter(
        None,
        at_least=1,
        meaning="So many times more pairs, the best by QCRS, go on to CRS and refined trunks, with policy global "
        "within limits so many times wider; null = the policy's own: "
        f"{', '.join(f'{policy} {breadth}' for policy, breadth in BREADTH.items())}.",
    )
    pool: int = parameter(
        4,
        at_least=1,
        meaning="So many times more pairs than top are constructed, to choose from (policy varied).",
    )
    min_iou: float = parameter(
        0.9,
        at_least=0,
        at_most=1,
        meaning="Least IoU of the worse shape of a chosen pair; others are chosen only where too few have it (policy "
        "varied).",
    )
    min_surprise: float = parameter(
        0.0, at_least=0, meaning="Least surprise of a pair: how much its shapes differ (policy varied)."
    )
    classes: tuple[str, ...] = parameter(
        (), parse=parse_names, meaning="Only pairs with a shape of one of these classes, such as [bird,fish]."
    )
    shapes: tuple[str, ...] = parameter((), parse=parse_names, meaning="Only pairs with one of these shapes, by name.")
    exclude: tuple[str, ...] = parameter((), parse=parse_names, meaning="No pair with one of these shapes or classes.")
    pieces: tuple[int, ...] = parameter(
        (), at_least=3, parse=parse_pieces, meaning="Only so many pieces: 4, 3..5, or a list (policy varied)."
    )
    flat: bool = parameter(
        False,
        meaning="Only transforms that swing in one plane (policy varied).",
    )

    @property
    def breadth_of_policy(self) -> int:
        """``breadth``, or the policy's own."""
        return BREADTH[self.policy] if self.breadth is None else self.breadth

    @property
    def selected(self) -> int:
        """Most pairs that go on to CRS."""
        return self.breadth_of_policy * self.top

    @property
    def constructed(self) -> int:
        """Most pairs that are constructed."""
        return self.top * (min(self.pool, self.breadth_of_policy) if self.policy == "varied" else 1)

    def check_together(self) -> None:
        """Check that the policy heeds the wishes; raises `riot.errors.ParameterError`."""
        for name in ("pieces", "flat", "min_surprise"):
            if getattr(self, name) and self.policy != "varied":
                raise ParameterError(name, f"needs select.policy=varied; {self.policy} does not heed it")

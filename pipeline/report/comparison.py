"""Compare the paper's method with the exact one on the pairs of a run that both constructed."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import astuple, dataclass
from statistics import median
from typing import Any

Row = Mapping[str, Any]


@dataclass(frozen=True)
class Figures:
    """One transform by one of the two methods, as `transforms` has it: areas of unit-area shapes, lengths in ``L_c``.

    ``iou`` and ``hausdorff`` are of the worse shape; an exact one's residual is its certificate's, as ``gaps`` and
    ``overlaps`` of the worse assembly.
    """

    iou: float
    gaps: float
    overlaps: float
    outside: float
    hausdorff: float

    @property
    def residual(self) -> float:
        """Gaps, overlaps and outside together."""
        return self.gaps + self.overlaps + self.outside


@dataclass(frozen=True)
class Compared:
    """One pair, by its row in `transforms`; ``unbent`` is the IoU of the exact transform without a bend, if known."""

    rank: int
    name_p: str
    name_q: str
    exact: Figures
    paper: Figures
    unbent: float | None


@dataclass(frozen=True)
class Comparison:
    """All pairs that were made by both, and the mean time that the stages took for a pair, nan = not known."""

    pairs: tuple[Compared, ...]
    seconds_exact: float
    seconds_paper: float

    @property
    def medians(self) -> tuple[Figures, Figures]:
        """Of each figure by itself: exact, and the paper's."""
        return _medians(pair.exact for pair in self.pairs), _medians(pair.paper for pair in self.pairs)

    @property
    def unbent(self) -> float | None:
        """The median IoU of the exact transforms without a bend; None if the run does not bend."""
        ious = [pair.unbent for pair in self.pairs if pair.unbent is not None]
        return median(ious) if ious else None

    @property
    def sentence(self) -> str:
        """The result of the comparison, in a sentence."""
        exact, paper = self.medians
        residual = median(pair.paper.residual for pair in self.pairs)
        ours = f"{exact.iou:.3f} exact"
        if self.unbent is not None:
            ours = f"{exact.iou:.3f} bent and exact, {self.unbent:.3f} exact"
        sentence = (
            f"Beside the paper's method, on the same trunks ({len(self.pairs)} of the best): "
            f"median IoU {ours}, {paper.iou:.3f} the paper's, whose pieces leave "
            f"{residual:.1g} of gaps, overlaps and outside"
        )
        if math.isfinite(self.seconds_exact) and math.isfinite(self.seconds_paper):
            sentence += f"; {self.seconds_exact:.2g} s and {self.seconds_paper:.2g} s a pair"
        return f"{sentence}."


def read_comparison(transforms: Iterable[Row], timings: Iterable[Row]) -> Comparison | None:
    """From the rows of `transforms` and `timings`; None if no pair was made by both."""
    pairs = tuple(_compared(row) for row in transforms if row.get("paper_iou") is not None)
    if not pairs:
        return None
    times = {str(row["stage"]): _seconds(row) for row in timings}
    return Comparison(pairs, times.get("construct", math.nan), times.get("paper", math.nan))


def _medians(figures: Iterable[Figures]) -> Figures:
    return Figures(*(median(column) for column in zip(*map(astuple, figures), strict=True)))


def _compared(row: Row) -> Compared:
    gaps, overlaps = max((abs(row[f"gap_{side}"]), abs(row[f"overlap_{side}"])) for side in "pq")
    exact = Figures(row["iou"], gaps, overlaps, 0.0, max(row["hausdorff_p"], row["hausdorff_q"]))
    names = ("paper_iou", "paper_gaps", "paper_overlaps", "paper_outside", "paper_hausdorff")
    paper = Figures(*(row[name] for name in names))
    return Compared(row["rank"], row["name_i"], row["name_j"], exact, paper, row.get("unbent_iou"))


def _seconds(row: Row) -> float:
    items, seconds = row["cached"] + row["computed"], row.get("stored_seconds")
    return float(seconds) / items if items and seconds is not None else math.nan

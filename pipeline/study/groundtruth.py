"""How well the search finds exact pairs that are hidden in a run's collection, and how little it deforms them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields

import numpy as np

from pipeline.study import plots
from pipeline.study.findings import Findings, Sheet, of_columns
from pipeline.study.finished import StudiedRun
from pipeline.study.hidden import hide
from pipeline.study.partners import StudiedPartners
from pipeline.study.recovery import (
    QUANTILES,
    WAYS,
    Closeness,
    Recovery,
    RecoverySearch,
    RecoveryShare,
    figures,
    quantiles,
)
from pipeline.tables.schemas import column
from riot.errors import needs_extra
from riot.parameters import QCRS_VARIANTS, QcrsVariant
from riot.parameters.field import ParameterGroup, parameter
from riot.types import FloatArray

with needs_extra("mine"):
    import pyarrow as pa

PIECES = (3, 4, 5, 6)
"""Numbers of pieces of the hidden pairs, in turn."""

RANKS = 400
"""Greatest rank of the recall curve (ours)."""


@dataclass(frozen=True)
class Parameters(ParameterGroup):
    """Which exact pairs are hidden, and how far their partners are searched."""

    pairs: int = parameter(20, at_least=1, meaning="Exact pairs that are hidden.")
    deform: float = parameter(
        0.0, at_least=0, unit="√area", meaning="Amplitude of the waves that deform hidden shapes before they are drawn."
    )
    keep: int = parameter(100, at_least=1, meaning="Partners of a hidden shape, the best by QCRS, that go on to CRS.")
    few: int = parameter(5, at_least=1, meaning="Of these the best by CRS, which are constructed.")


def study(finished: StudiedRun, parameters: Parameters, say: Callable[[str], None]) -> Findings:
    """Ranks of the true partner by QCRS, of both variants, and by CRS and IoU with the run's; IoU of the hidden pairs.

    Trunks and refinement are found with the run's parameters.
    """
    pairs, left_out = hide(parameters.pairs, PIECES, parameters.deform)
    shapes = [side.shape for pair in pairs for side in (pair.p, pair.q)] + finished.shapes
    settings, own_variant = finished.config, finished.config.qcrs.variant
    searched = {
        variant: StudiedPartners(shapes, settings.trunks, settings.refine, settings.crs, variant)
        for variant in QCRS_VARIANTS
    }
    search = RecoverySearch(pairs, searched[own_variant], parameters.keep, parameters.few)
    recoveries = search.run(say)
    close = [search.closeness(number) for number in range(len(pairs))]
    ranks = {own_variant: np.array([float(recovery.quick_rank) for recovery in recoveries])}
    for variant, partners in searched.items():
        if variant != own_variant:
            say(f"QCRS, {variant}, of the hidden shapes …")
            ranks[variant] = _quick_ranks(partners, len(recoveries))
    return _findings(finished, parameters, recoveries, close, ranks, left_out)


def _quick_ranks(partners: StudiedPartners, hidden: int) -> FloatArray:
    """(hidden,) rank of each hidden shape's partner by QCRS, from 1, behind all of equal score."""
    scores = partners.quick_scores(hidden)
    mates = scores[np.arange(hidden), np.arange(hidden) ^ 1]
    return np.asarray((scores >= mates[:, None]).sum(axis=1), dtype=np.float64)


def _findings(
    finished: StudiedRun,
    parameters: Parameters,
    recoveries: Sequence[Recovery],
    close: Sequence[Closeness],
    ranks: dict[QcrsVariant, FloatArray],
    left_out: int,
) -> Findings:
    rows = figures(recoveries, close, parameters.keep)
    causes = Counter(recovery.cause for recovery in recoveries if recovery.cause)
    cross = np.array([np.nan if recovery.cross_rank is None else recovery.cross_rank for recovery in recoveries])
    worst = np.array([recovery.found for recovery in close])
    curves = {**{f"QCRS, {variant}": by_shape for variant, by_shape in ranks.items()}, "CRS": cross}
    depths = (1, 3, 10, 50, 100, 400)
    recall_rows = [
        (name, *(f"{np.mean(by_shape <= depth):.1%}" for depth in depths)) for name, by_shape in curves.items()
    ]
    spread = [
        (WAYS[way], *(f"{row[word]:.5f}" for word in QUANTILES), f"{row['refused']:.0f}")
        for way, row in quantiles(close).items()
    ]
    return Findings(
        f"Hidden exact pairs in {finished.mined.dataset}",
        f"{len(recoveries)} shapes of {len(close)} exact pairs among {len(recoveries) + len(finished.mined.names)} "
        f"shapes; {left_out} pairs were left out as degenerate. CRS and construction follow QCRS of the run's variant, "
        f"{finished.config.qcrs.variant}, whose first {parameters.keep} go on.",
        _table(recoveries, close, ranks),
        [
            Sheet("Shares", ("share", "count", "of", "95 %", "target", *_sizes(rows)), [_cells(row) for row in rows]),
            Sheet("Partners among the first", ("by", *map(str, depths)), recall_rows),
            Sheet("IoU of the worse shape", ("given", *QUANTILES, "refused"), spread),
            Sheet("Partner not first in the end; lost at", ("cause", "shapes"),
                  [(cause, str(count)) for cause, count in causes.most_common()]),
        ],
        {
            "recall": (plots.recall(curves, RANKS), "Partners found among the first r of a ranking"),
            "iou": (plots.histograms({"IoU": worst}, "IoU of the worse shape", "pairs"),
                    "Hidden pairs, constructed as the search finds them"),
        },
    )  # fmt: skip


def _sizes(rows: Sequence[RecoveryShare]) -> list[str]:
    return [f"n = {n}" for n in sorted({n for row in rows for n in row.by_n})]


def _cells(row: RecoveryShare) -> tuple[str, ...]:
    aim = "" if row.target is None else f"{row.target:.0%}"
    by_n = [f"{good}/{total}" for good, total in row.by_n.values()]
    return row.name, str(row.good), str(row.of), f"{row.low:.1%} – {row.high:.1%}", aim, *by_n


def _table(
    recoveries: Sequence[Recovery], close: Sequence[Closeness], ranks: dict[QcrsVariant, FloatArray]
) -> pa.Table:
    kinds = {"str": pa.string(), "int": pa.int32(), "bool": pa.bool_(), "float": pa.float64(), "int | None": pa.int32()}
    meanings = {
        "name": "hidden shape",
        "n": "pieces of its pair",
        "topology": "kind of its dissection trees",
        "curved": "whether its arcs are curved",
        "quick_rank": "rank of its partner by QCRS",
        "quick_score": "QCRS with its partner",
        "quick_lost": "test that its or its partner's true trunk fails for QCRS, empty = none",
        "cross_rank": "rank of its partner by CRS, null = did not get so far",
        "cross_score": "CRS with its partner",
        "full_lost": "test that its or its partner's true trunk fails for CRS, empty = none",
        "final_rank": "rank of its partner by IoU, null = did not get so far",
        "first": "the partner of highest IoU",
        "first_iou": "IoU of the worse shape with it",
        "cause": "where its partner was lost, empty = first in the end",
    }
    columns = [
        (
            column(entry.name, kinds[str(entry.type)], meanings[entry.name]),
            [getattr(recovery, entry.name) for recovery in recoveries],
        )
        for entry in fields(Recovery)
    ]
    columns += [
        (
            column(f"rank_{variant}", pa.int32(), f"rank of its partner by QCRS, variant {variant}"),
            by_shape.astype(np.int32).tolist(),
        )
        for variant, by_shape in ranks.items()
    ]
    columns += [
        (column(f"iou_{way}", pa.float64(), f"IoU of the pair's worse shape: {words}; nan = refused", "1"),
         [getattr(close[k // 2], way) for k in range(len(recoveries))])
        for way, words in WAYS.items()
    ]  # fmt: skip
    return of_columns("Hidden shapes and what became of their partners.", columns)

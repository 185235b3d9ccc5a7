"""How often QCRS orders pairs as CRS does: the paper's experiment (§6), over more pairs, and for both variants."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from pipeline.errors import StartError
from pipeline.study import plots
from pipeline.study.findings import Findings, Sheet, of_columns
from pipeline.study.finished import StudiedRun
from pipeline.study.partners import StudiedPartners
from pipeline.study.statistics import Agreement, agreement, calibration, precision
from pipeline.tables.schemas import column
from riot.errors import needs_extra
from riot.parameters import QCRS_VARIANTS, QcrsVariant
from riot.parameters.field import ParameterGroup, parameter
from riot.scores.qcrs import score_pairs
from riot.scores.trunk_stack import stack
from riot.scores.trunks import compared_trunks
from riot.types import FloatArray, IntArray

with needs_extra("mine"):
    import pyarrow as pa

PAPER = 0.774
"""Share of 1,000 random pairs of pairs that the paper found ordered alike."""

TOPS = (10, 30, 100)
"""Numbers of best pairs that are compared (ours)."""

BINS = 20
"""Equally full bins of the score in the figures (ours)."""


@dataclass(frozen=True)
class Parameters(ParameterGroup):
    """Sizes of the samples."""

    pairs: int = parameter(3000, at_least=3, meaning="Most pairs of each sample.")
    draws: int = parameter(1000, at_least=1, meaning="Pairs of pairs of a sample whose orders are compared.")
    bounds: int = parameter(200, at_least=0, meaning="Pairs of a sample that are refined.")
    seed: int = parameter(2018, at_least=0, meaning="Seed of the samples.")


@dataclass(frozen=True, eq=False)
class PairSample:
    """Pairs (k, 2), i < j, of one kind, with their CRS, QCRS by variant, and greatest IoU, nan = not refined."""

    kind: str
    pairs: IntArray
    cross: FloatArray
    quick: dict[QcrsVariant, FloatArray]
    bound: FloatArray


def study(finished: StudiedRun, parameters: Parameters, say: Callable[[str], None]) -> Findings:
    """Agreement of both variants of QCRS with CRS on three samples, and of all with the IoU that refined trunks allow.

    ``uniform``: pairs drawn with equal chances from all, as a ranking of the collection meets them. ``classes``: pairs
    of the shapes of best reversibility of each class, the paper's. ``selected``: the best pairs, which the run refined
    itself; CRS and IoU are those of its tables, as is QCRS of its own variant everywhere.
    """
    rng = np.random.default_rng(parameters.seed)
    chosen = {"uniform": uniform(len(finished.mined.names), parameters.pairs, rng)}
    of_classes = best_of_classes(finished, parameters.pairs, rng)
    if len(of_classes) >= 3:
        chosen["classes"] = of_classes
    partners = StudiedPartners(finished.shapes, finished.config.trunks, finished.config.refine, finished.config.crs)
    samples = []
    for kind, pairs in chosen.items():
        say(f"CRS of {len(pairs)} pairs, {kind} …")
        cross = np.array([partners.cross(i, j) for i, j in pairs.tolist()])
        quick = {variant: _quick(finished, pairs, variant, partners) for variant in QCRS_VARIANTS}
        known = np.isfinite(quick[finished.config.qcrs.variant])  # else the run set the pair aside
        pairs, cross, quick = pairs[known], cross[known], {variant: scores[known] for variant, scores in quick.items()}
        bound = np.full(len(pairs), np.nan)
        refined = rng.permutation(len(pairs))[: parameters.bounds if kind == "uniform" else 0]
        for index in refined.tolist():
            bound[index] = max(0.0, partners.bound(*pairs[index].tolist()))
        samples.append(PairSample(kind, pairs, cross, quick, bound))
    mined = _selected(finished, partners)
    return _findings(finished, parameters, [*samples, *([mined] if len(mined.pairs) >= 3 else [])])


def uniform(shapes: int, count: int, rng: np.random.Generator) -> IntArray:
    """(k, 2) pairs i < j of so many shapes, each with equal chances, without repeats; raises `StartError` below 3."""
    every = shapes * (shapes - 1) // 2
    if every < 3:
        raise StartError(f"a study of pairs needs 3 shapes at least, and the run has {shapes}")
    numbers = np.sort(rng.choice(every, min(count, every), replace=False))
    # Pair number k lies in the row i that begins at i (2 shapes − i − 1) / 2.
    begins = np.arange(shapes) * (2 * shapes - np.arange(shapes) - 1) // 2
    i = np.searchsorted(begins, numbers, side="right") - 1
    i = np.minimum(i, shapes - 2)
    return np.stack([i, numbers - begins[i] + i + 1], axis=1).astype(np.int64)


def best_of_classes(finished: StudiedRun, count: int, rng: np.random.Generator) -> IntArray:
    """(k, 2) pairs i < j among the shape of best reversibility of each class, at most ``count`` of them at random."""
    reversible = np.nan_to_num(finished.values("reversibility", "score"), nan=-1.0)
    best: dict[str, int] = {}
    for number, cls in enumerate(finished.classes):
        if cls and (cls not in best or reversible[number] > reversible[best[cls]]):
            best[cls] = number
    members = np.array(sorted(best.values()), dtype=np.int64)
    if len(members) < 2:
        return np.empty((0, 2), dtype=np.int64)
    pairs = uniform(len(members), count, rng) if len(members) > 2 else np.array([[0, 1]])
    drawn: IntArray = members[pairs]
    return drawn


def _selected(finished: StudiedRun, partners: StudiedPartners) -> PairSample:
    """The pairs with CRS that the run refined."""
    table = finished.table("crs", "i", "j", "score", "bound")
    i, j, cross, bound = (np.asarray(column_values.to_numpy(), dtype=np.float64) for column_values in table.columns)
    pairs = np.stack([i, j], axis=1).astype(np.int64)
    quick = {variant: _quick(finished, pairs, variant, partners) for variant in QCRS_VARIANTS} if len(pairs) else {}
    known = np.isfinite([cross, bound, *quick.values()]).all(axis=0)
    of_known = {variant: column_values[known] for variant, column_values in quick.items()}
    return PairSample("selected", pairs[known], cross[known], of_known, bound[known])


def _quick(finished: StudiedRun, pairs: IntArray, variant: QcrsVariant, partners: StudiedPartners) -> FloatArray:
    """QCRS of a variant: from the run's tables if it is the run's own, else computed with the variant's sigmas."""
    settings = finished.config
    if variant == settings.qcrs.variant:
        return finished.quick_scores(pairs)
    numbers, local = np.unique(pairs, return_inverse=True)
    stacked = stack([compared_trunks(partners.shapes[k], variant, settings.trunks) for k in numbers.tolist()])
    return score_pairs(stacked, stacked, local.reshape(-1, 2).astype(np.int64), QCRS_VARIANTS[variant]).score


def _findings(finished: StudiedRun, parameters: Parameters, samples: list[PairSample]) -> Findings:
    meets, tops, figures = [], [], {}
    agreements: dict[tuple[str, str], Agreement] = {}
    for sample in samples:
        for name, reference_name, score, reference in _comparisons(sample):
            agreed = agreement(score, reference, parameters.draws, parameters.seed)
            row = [f"{precision(score, reference, top):.0%}" if top < len(score) else "–" for top in TOPS]
            meets.append((sample.kind, name, reference_name, *_cells(agreed)))
            tops.append((sample.kind, name, reference_name, *row))
            if reference_name == "CRS":
                agreements[sample.kind, name] = agreed
                figures[f"{sample.kind}-{name.split()[1]}"] = (
                    plots.scatter((score, reference), calibration(score, reference, BINS), name, reference_name),
                    f"{name} and CRS, {sample.kind} pairs",
                )
    shares = ", ".join(
        f"{agreed.alike} of {agreed.drawn} draws ({agreed.low:.1%} to {agreed.high:.1%}) by {name}"
        for (kind, name), agreed in agreements.items()
        if kind == "uniform"
    )
    head = ("pairs", "score", "beside", "pairs", "alike", "95 %", "of all", "ties half", "Kendall", "Spearman",
            "nearly tied")  # fmt: skip
    return Findings(
        f"Consistency of QCRS with CRS on {finished.mined.dataset}",
        f"Two random pairs of shapes are ordered as by CRS in {shares}; in the paper in {PAPER:.1%} of "
        f"1,000. The run's own variant is {finished.config.qcrs.variant}. Pairs of pairs that a score ties have no "
        "order and are not drawn; “ties half” counts those that QCRS ties as half alike. “Nearly tied” is the share of "
        "those ordered otherwise whose CRS or IoU are less than 0.05 apart. IoU is what refined trunks allow the worse "
        "shape.",
        _table(samples),
        [
            Sheet("Pairs of pairs ordered alike", head, meets, 3),
            Sheet("Of the best by the score, so many are among as many best by the other",
                  ("pairs", "score", "beside", *(f"first {k}" for k in TOPS)), tops, 3),
        ],
        figures,
    )  # fmt: skip


def _comparisons(sample: PairSample) -> Iterator[tuple[str, str, FloatArray, FloatArray]]:
    """Names and values of each score and its reference, if both have at least two different values."""
    refined = np.isfinite(sample.bound)
    scores = {f"QCRS {variant}": quick for variant, quick in sample.quick.items()}
    every = [(name, "CRS", score, sample.cross) for name, score in scores.items()]
    every += [(name, "IoU", score[refined], sample.bound[refined])
              for name, score in {**scores, "CRS": sample.cross}.items()]  # fmt: skip
    for comparison in every:
        if all(len(values) >= 3 and np.ptp(values) > 0.0 for values in comparison[2:]):
            yield comparison


def _cells(agreed: Agreement) -> tuple[str, ...]:
    return (
        f"{agreed.pairs:,}",
        f"{agreed.alike} of {agreed.drawn}",
        f"{agreed.low:.1%} – {agreed.high:.1%}",
        *(
            f"{value:.3f}"
            for value in (agreed.share, agreed.halved, agreed.kendall, agreed.spearman, agreed.nearly_tied)
        ),
    )


def _table(samples: list[PairSample]) -> pa.Table:
    score = "score in [0, 1]"
    joined = {
        "cross": np.concatenate([sample.cross for sample in samples]),
        "bound": np.concatenate([sample.bound for sample in samples]),
    }
    pairs = np.concatenate([sample.pairs for sample in samples])
    return of_columns(
        "Sampled pairs with their scores.",
        [
            (column("sample", pa.string(), "how the pair was drawn"),
             [sample.kind for sample in samples for _ in range(len(sample.pairs))]),
            (column("i", pa.int32(), "first shape", "shape number"), pairs[:, 0]),
            (column("j", pa.int32(), "second shape", "shape number"), pairs[:, 1]),
            *((column(f"qcrs_{variant}", pa.float64(), f"QCRS, variant {variant}", score),
               np.concatenate([sample.quick[variant] for sample in samples])) for variant in QCRS_VARIANTS),
            (column("crs", pa.float64(), "CRS", score), joined["cross"]),
            (column("bound", pa.float64(), "greatest IoU of the worse shape on refined trunks; nan = not refined", "1"),
             joined["bound"]),
        ],
    )  # fmt: skip

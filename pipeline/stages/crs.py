"""Cross-reversibility score of one selected pair, and the trunk pairs that construction may try."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.plan.progress import Progress
from pipeline.plan.work_item import WorkItem
from pipeline.stages.select import selected
from pipeline.stages.shape_arrays import ErrorRow, attempt, expect_shape
from pipeline.stages.stage import Column, Stage, TableColumns
from pipeline.stages.trunk_arrays import unpack_trunks
from pipeline.store.artifact import AnyArray, Artifact
from riot import scores

if TYPE_CHECKING:
    from riot.scores.crs import CrossScore

TERMS = ("score", "s_edge", "s_angle", "s_area", "area")


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: tuple[int, int]) -> Artifact:
    """Batches of P and Q, their full trunks → the best trunk pairs, best first (see `pack_scores`); CRS is the first's.

    ``parameters`` are those of CRS and the number of trunk pairs to keep. Without two trunks of the same
    size there is no trunk pair, and CRS is 0.
    """
    batch_p, batch_q, full_p, full_q = inputs
    settings, count = parameters
    p, q = expect_shape(batch_p, spec[0]), expect_shape(batch_q, spec[1])
    trunks_p, trunks_q = unpack_trunks(full_p, 0), unpack_trunks(full_q, 0)
    errors: list[ErrorRow] = []
    best: list[CrossScore] = []
    if len(trunks_p) and len(trunks_q):

        def score() -> list[CrossScore]:
            return scores.crs.best_trunk_pairs(p, q, trunks_p, trunks_q, settings, count)

        best = attempt(0, score, errors) or []
    document = {"trunks_p": len(trunks_p), "trunks_q": len(trunks_q), "errors": errors}
    return Artifact(pack_scores(best), document)


def pack_scores(trunk_pairs: Sequence[CrossScore]) -> dict[str, AnyArray]:
    """Scores as arrays: `TERMS` and ``evaluations`` (k,), ``offsets`` (k+1,) into ``trunk_p`` and ``trunk_q``."""
    arrays: dict[str, AnyArray] = {
        name: np.array([getattr(pair, name) for pair in trunk_pairs], dtype=np.float64) for name in TERMS
    }
    arrays["evaluations"] = np.array([pair.evaluations for pair in trunk_pairs], dtype=np.int64)
    arrays["offsets"] = np.cumsum([0, *(pair.n for pair in trunk_pairs)], dtype=np.int64)
    arrays["trunk_p"] = np.concatenate([np.empty(0, np.int64), *(pair.trunk_a for pair in trunk_pairs)])
    arrays["trunk_q"] = np.concatenate([np.empty(0, np.int64), *(pair.trunk_b for pair in trunk_pairs)])
    return arrays


def unpack_scores(artifact: Artifact) -> list[CrossScore]:
    """Undo `pack_scores`."""
    arrays = artifact.arrays
    return [
        scores.crs.CrossScore(
            trunk_a=np.array(arrays["trunk_p"][low:high]),
            trunk_b=np.array(arrays["trunk_q"][low:high]),
            evaluations=int(arrays["evaluations"][k]),
            **{name: float(arrays[name][k]) for name in TERMS},
        )
        for k, (low, high) in enumerate(zip(arrays["offsets"][:-1], arrays["offsets"][1:], strict=True))
    ]


def best_score(artifact: Artifact) -> CrossScore:
    """The pair's CRS with its trunks; `riot.scores.crs.NO_SCORE` where it has no trunk pair."""
    trunk_pairs = unpack_scores(artifact)
    return trunk_pairs[0] if trunk_pairs else scores.crs.NO_SCORE


def items(progress: Progress) -> list[WorkItem]:
    """A work item for each selected pair, in order."""
    recipe, ingest = progress.recipes["crs"], progress.work["ingest"]
    full = {item.members[0]: item for item in progress.work["trunks_full"]}
    work = []
    for p, q in selected(progress).pairs.tolist():
        (batch_p, index_p), (batch_q, index_q) = progress.locate(p), progress.locate(q)
        sources = (ingest[batch_p], ingest[batch_q], full[p], full[q])
        work.append(
            recipe.item(
                recipe.parts([full[p].key, full[q].key]),
                [item.reference for item in sources],
                spec=(index_p, index_q),
                members=(p, q),
            )
        )
    return work


def _row(artifact: Artifact) -> Mapping[str, Any]:
    best = best_score(artifact)
    return {
        **{name: getattr(best, name) for name in ("score", "s_edge", "s_angle", "s_area", "n", "evaluations")},
        "trunk_i": best.trunk_a.tolist(),
        "trunk_j": best.trunk_b.tolist(),
        "trunks_i": artifact.document["trunks_p"],
        "trunks_j": artifact.document["trunks_q"],
    }


def _row_of_transform(artifact: Artifact) -> Mapping[str, Any]:
    best = best_score(artifact)
    return {"crs": best.score, **{name: getattr(best, name) for name in ("s_edge", "s_angle", "s_area", "n")}}


SCORE = "score in [0, 1]"

STAGE = Stage(
    name="crs",
    unit="pairs",
    after=("trunks_full",),
    parameters=("crs", "refine.candidates"),
    items=items,
    run=run,
    scope="pair",
    known_after="select",
    at_most=lambda config: config.select.selected,
    bundle=4,
    tables=(
        TableColumns(
            "crs",
            (
                Column("score", "float64", "CRS = min(s_edge, s_angle, s_area) of the best pair of trunks", SCORE),
                Column("s_edge", "float64", "edge term, equation 3", SCORE),
                Column("s_angle", "float64", "angle term, equation 4", SCORE),
                Column("s_area", "float64", "area term, equation 5, of the worse direction", SCORE),
                Column("n", "int8", "vertices of the two trunks, 0 = none", "count"),
                Column("trunk_i", "list<int64>", "trunk of i, counter-clockwise", "index of boundary point"),
                Column(
                    "trunk_j",
                    "list<int64>",
                    "trunk of j in corresponding order, clockwise",
                    "index of boundary point",
                ),
                Column("trunks_i", "int32", "full trunks of i", "count"),
                Column("trunks_j", "int32", "full trunks of j", "count"),
                Column("evaluations", "int64", "area terms evaluated", "count"),
            ),
            _row,
            "Cross-reversibility score of the selected pairs (paper §4.2).",
        ),
        TableColumns(
            "transforms",
            (
                Column("crs", "float64", "CRS of the pair", SCORE),
                Column("s_edge", "float64", "edge term of the CRS", SCORE),
                Column("s_angle", "float64", "angle term of the CRS", SCORE),
                Column("s_area", "float64", "area term of the CRS", SCORE),
                Column("n", "int8", "pieces", "count"),
            ),
            _row_of_transform,
        ),
    ),
)

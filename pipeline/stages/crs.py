"""Cross-reversibility score of one selected pair, and the trunk pairs that construction may try."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from pipeline.stages.items import ErrorRow, attempt, expect_shape
from pipeline.stages.trunk_arrays import unpack_trunks
from pipeline.store.artifact import AnyArray, Artifact
from riot.scores.crs import CrossScore, best_trunk_pairs

TERMS = ("score", "s_edge", "s_angle", "s_area", "area")


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: tuple[int, int]) -> Artifact:
    """Batches of P and Q, their full trunks → the best trunk pairs, best first (see `pack_scores`); CRS is the first's.

    Parameters are those of CRS and the number of trunk pairs to keep. No trunks of one size: no trunk pair, and CRS 0.
    """
    batch_p, batch_q, full_p, full_q = inputs
    settings, count = parameters
    p, q = expect_shape(batch_p, spec[0]), expect_shape(batch_q, spec[1])
    trunks_p, trunks_q = unpack_trunks(full_p, 0), unpack_trunks(full_q, 0)
    errors: list[ErrorRow] = []
    scores: list[CrossScore] = []
    if len(trunks_p) and len(trunks_q):
        scores = attempt(0, lambda: best_trunk_pairs(p, q, trunks_p, trunks_q, settings, count), errors) or []
    document = {"trunks_p": len(trunks_p), "trunks_q": len(trunks_q), "errors": errors}
    return Artifact(pack_scores(scores), document)


def pack_scores(scores: Sequence[CrossScore]) -> dict[str, AnyArray]:
    """Scores as arrays: `TERMS` and ``evaluations`` (k,), ``offsets`` (k+1,) into ``trunk_p`` and ``trunk_q``."""
    arrays: dict[str, AnyArray] = {
        name: np.array([getattr(one, name) for one in scores], dtype=np.float64) for name in TERMS
    }
    arrays["evaluations"] = np.array([one.evaluations for one in scores], dtype=np.int64)
    arrays["offsets"] = np.cumsum([0, *(one.n for one in scores)], dtype=np.int64)
    arrays["trunk_p"] = np.concatenate([np.empty(0, np.int64), *(one.trunk_a for one in scores)])
    arrays["trunk_q"] = np.concatenate([np.empty(0, np.int64), *(one.trunk_b for one in scores)])
    return arrays


def unpack_scores(artifact: Artifact) -> list[CrossScore]:
    """Undo `pack_scores`."""
    arrays = artifact.arrays
    return [
        CrossScore(
            trunk_a=np.array(arrays["trunk_p"][low:high]),
            trunk_b=np.array(arrays["trunk_q"][low:high]),
            evaluations=int(arrays["evaluations"][k]),
            **{name: float(arrays[name][k]) for name in TERMS},
        )
        for k, (low, high) in enumerate(zip(arrays["offsets"][:-1], arrays["offsets"][1:], strict=True))
    ]

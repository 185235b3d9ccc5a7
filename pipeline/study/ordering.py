"""How much the order of shapes by S_r changes with one of its sigmas. Ours."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from pipeline.study.statistics import precision
from riot.types import FloatArray


@dataclass(frozen=True)
class SigmaOrder:
    """The order by S_r with one value of one sigma, beside the run's own: Kendall's τ, and how much of the best tenth
    stays there."""

    parameter: str
    value: float
    default: bool
    kendall: float
    kept: float


def reordered(s1: FloatArray, s2: FloatArray, pa_factor: float, w_factor: float) -> FloatArray:
    """S_r (paper, equation 11) by sigmas that are so many times those by which the terms ``s1`` and ``s2`` were made.

    Both terms are exp(−d² / 2σ²), so that a power of theirs is what another σ gives.
    """
    return np.asarray(np.minimum(s1**pa_factor**-2, s2**w_factor**-2), dtype=np.float64)


def orders(
    s1: FloatArray, s2: FloatArray, default: Mapping[str, float], values: Mapping[str, Sequence[float]]
) -> Iterator[SigmaOrder]:
    """By ``sigma_pa``, then ``sigma_w``, and rising value, the default's among them; both terms are the default's."""
    known = np.isfinite(s1) & np.isfinite(s2)
    s1, s2 = s1[known], s2[known]
    reference = np.minimum(s1, s2)
    best = math.ceil(len(reference) / 10)
    for name in ("sigma_pa", "sigma_w"):
        for value in sorted({*values[name], default[name]}):
            factors = [value / default[name] if name == sigma else 1.0 for sigma in ("sigma_pa", "sigma_w")]
            score = reordered(s1, s2, *factors)
            kendall = float(stats.kendalltau(score, reference).statistic)
            yield SigmaOrder(name, value, value == default[name], kendall, precision(score, reference, best))

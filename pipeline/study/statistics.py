"""Agreement of two scores of the same pairs, and confidence intervals of shares. Ours, on `scipy.stats`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from riot.types import FloatArray

CONFIDENCE = 0.95
"""Confidence level of all intervals (ours)."""

TIED = 0.05
"""Scores that differ by less than this are nearly tied (ours)."""


def wilson(good: int, trials: int, together: int = 1) -> tuple[float, float]:
    """95 % interval, by Wilson, of the share of ``good`` among ``trials``.

    Trials that come out alike in groups of ``together`` count as one: the interval is that of so many times fewer
    trials with the same share. Raises ValueError without trials. Ours, on `scipy.stats.binomtest`.

    >>> [round(end, 3) for end in wilson(9, 10)]
    [0.596, 0.982]
    >>> [round(end, 3) for end in wilson(18, 20, together=2)]
    [0.596, 0.982]
    """
    # The interval depends on its deviations² / trials alone: fewer trials are the same as more deviations.
    deviations = stats.norm.ppf(0.5 + CONFIDENCE / 2) * np.sqrt(together)
    confidence = CONFIDENCE if together == 1 else float(1.0 - 2.0 * stats.norm.sf(deviations))
    interval = stats.binomtest(good, trials).proportion_ci(confidence, method="wilson")
    return float(interval.low), float(interval.high)


@dataclass(frozen=True)
class Agreement:
    """How far a score orders pairs as a reference does.

    ``alike`` of ``drawn`` random pairs of pairs are ordered alike, ``low`` to ``high`` the share's 95 % interval;
    ``share`` is that of all pairs of pairs. Pairs of pairs that either score ties have no order and do not count. Of
    those ordered otherwise, ``nearly_tied`` is the share whose reference scores differ by less than `TIED`. ``halved``
    is the share of all that the reference orders, where those that the score ties count half.
    """

    pairs: int
    alike: int
    drawn: int
    low: float
    high: float
    share: float
    kendall: float
    spearman: float
    nearly_tied: float
    halved: float


def agreement(score: FloatArray, reference: FloatArray, draws: int, seed: int) -> Agreement:
    """Compare (k,) scores with (k,) reference scores, on ``draws`` random pairs of pairs at most, and on all.

    Raises ValueError when no two pairs differ in both.
    """
    i, j = np.triu_indices(len(score), 1)
    first, second = np.sign(score[i] - score[j]), np.sign(reference[i] - reference[j])
    ordered = np.flatnonzero((first != 0.0) & (second != 0.0))
    if not len(ordered):
        raise ValueError("no two pairs differ in both scores: there is nothing to compare")
    same = (first == second)[ordered]
    drawn = np.random.default_rng(seed).permutation(len(ordered))[:draws]
    alike = int(same[drawn].sum())
    apart = np.abs(reference[i] - reference[j])[ordered][~same]
    return Agreement(
        len(score),
        alike,
        len(drawn),
        *wilson(alike, len(drawn)),
        float(same.mean()),
        float(stats.kendalltau(score, reference).statistic),
        float(stats.spearmanr(score, reference).statistic),
        float((apart < TIED).mean()) if len(apart) else 0.0,
        float((0.5 + 0.5 * first * second)[second != 0.0].mean()),
    )


def precision(score: FloatArray, reference: FloatArray, count: int) -> float:
    """The share of the ``count`` best by ``score`` that are among the ``count`` best by ``reference``."""
    best = [set(np.argsort(-values, kind="stable")[:count].tolist()) for values in (score, reference)]
    return len(best[0] & best[1]) / min(count, len(score))


def calibration(score: FloatArray, reference: FloatArray, bins: int) -> list[tuple[float, float, float, float]]:
    """The reference by equally full ``bins`` of the score: mean score, and the reference's quartiles."""
    order = np.argsort(score, kind="stable")
    rows = []
    for bin_rows in np.array_split(order, bins):
        if len(bin_rows):
            low, middle, high = np.quantile(reference[bin_rows], (0.25, 0.5, 0.75)).tolist()
            rows.append((float(score[bin_rows].mean()), low, middle, high))
    return rows


def quantiles(values: Sequence[float] | FloatArray, shares: Sequence[float]) -> list[float]:
    """Quantiles of the finite values; nan without any."""
    known = np.asarray(values, dtype=np.float64)
    known = known[np.isfinite(known)]
    return np.quantile(known, shares).tolist() if len(known) else [math.nan] * len(shares)

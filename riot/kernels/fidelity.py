"""Two closed outlines' directions compared along a monotone correspondence: the loop of `riot.transform.fidelity`."""

from __future__ import annotations

import numpy as np

from riot.kernels.options import kernel
from riot.types import FloatArray


@kernel
def warped_difference(a: FloatArray, b: FloatArray, window: int, skew: float) -> float:
    """Mean angle, radians, between directions ``a`` (m,) and ``b`` (k,) of even samples of two outlines.

    Of all monotone correspondences from start to start and end to end that stay within ``window`` samples of the even
    one, that of least sum, where a step on one outline only costs ``skew`` more.
    """
    m, k = len(a), len(b)
    before, row = np.full(k, np.inf), np.full(k, np.inf)
    lengths_before, lengths = np.zeros(k), np.zeros(k)
    for i in range(m):
        row[:] = np.inf
        middle = i * (k - 1) // max(m - 1, 1)
        for j in range(max(middle - window, 0), min(middle + window + 1, k)):
            angle = abs((a[i] - b[j] + np.pi) % (2.0 * np.pi) - np.pi)
            if i == 0 and j == 0:
                row[j], lengths[j] = angle, 1.0
                continue
            best, length = np.inf, 0.0
            if i > 0 and j > 0:
                best, length = before[j - 1] + 2.0 * angle, lengths_before[j - 1] + 2.0
            if i > 0 and before[j] + angle + skew < best:
                best, length = before[j] + angle + skew, lengths_before[j] + 1.0
            if j > 0 and row[j - 1] + angle + skew < best:
                best, length = row[j - 1] + angle + skew, lengths[j - 1] + 1.0
            row[j], lengths[j] = best, length
        before[:] = row
        lengths_before[:] = lengths
    return float(before[k - 1] / lengths_before[k - 1])


def warm() -> None:
    """Compile on two bends."""
    warped_difference(np.array([0.0, 0.5, 1.0]), np.array([0.0, 1.0]), 3, 0.1)

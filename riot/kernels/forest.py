"""The data of the QCRS search: trunks of shapes, laid out for it, and the units of its distances (ours).

These are named tuples of arrays, which kernels accept; `riot.scores.trunk_stack.lay_out_forest` makes them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from riot.types import FloatArray, IntArray

Single = npt.NDArray[np.float32]
Int32Array = npt.NDArray[np.int32]


class Forest(NamedTuple):
    """The trunks of some shapes: each shape has a group for each n, and each group consists of leaves of similar
    trunks.

    ``groups`` (shapes + 1,) where the groups of each shape begin; for each group ``sizes`` (g,) is n, ``leaves`` (g +
    1,) where its leaves begin, ``tiles`` (g + 1,) where its boxes begin. ``trunks`` (l, QCRS_LEAF) numbers of the
    trunks among all; ``features`` (l, FEATURES, QCRS_LEAF) and ``boxes`` (tiles, 2 FEATURES, TILE_LEAVES) as
    `riot.kernels.leaves` says; ``facing`` (…,) the corners of the trunks of every leaf, side by side and backwards,
    from ``begins`` (g + 1,) for each group. ``starts``, ``offsets``, ``edges``, ``alphas``, ``betas``, ``areas`` as in
    `riot.scores.trunk_stack.TrunkStack`.
    """

    groups: IntArray
    sizes: IntArray
    leaves: IntArray
    tiles: IntArray
    begins: IntArray
    trunks: Int32Array
    features: Single
    boxes: Single
    facing: Single
    starts: IntArray
    offsets: IntArray
    edges: FloatArray
    alphas: FloatArray
    betas: FloatArray
    areas: FloatArray


class Scale(NamedTuple):
    """σ_E, σ_∠ and σ_A in absolute units, the greatest rounding error of a bound in single precision, how many times as
    far as the last partner a search looks for promising trunks, and by how much a score may be too low."""

    edge: float
    angle: float
    area: float
    slack: float
    margin: float
    epsilon: float

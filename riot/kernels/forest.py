"""What QCRS's search reads: the trunks of some shapes laid out for it, and the units of its distances (ours).

Tuples of arrays, which a kernel takes as they are; `riot.scores.qcrs.lay_out_forest` fills them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from riot.types import FloatArray, IntArray

Single = npt.NDArray[np.float32]
Int32Array = npt.NDArray[np.int32]


class Forest(NamedTuple):
    """The trunks of some shapes as the search wants them: of every shape one group for each n, of leaves of trunks.

    ``groups`` (shapes + 1,) where each shape's groups begin; of group g ``sizes`` (g,) is n, ``leaves`` (g + 1,) where
    its leaves begin, ``tiles`` (g + 1,) where its boxes do. ``trunks`` (l, LEAF) numbers of the trunks among all;
    ``features`` (l, FEATURES, LEAF) and ``boxes`` (tiles, 2 FEATURES, WIDE) as `riot.kernels.leaves` says; ``facing``
    (…,) the corners of every slot backwards and twice, from ``begins`` (g + 1,) for each group.
    ``starts``, ``offsets``, ``edges``, ``alphas``, ``betas``, ``areas`` as in `riot.scores.qcrs.TrunkStack`.
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
    """σ_E, σ_∠ and σ_A in absolute units, and by how much a bound in single precision may exceed what it bounds."""

    edge: float
    angle: float
    area: float
    slack: float

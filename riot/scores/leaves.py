"""Leaves: groups of similar trunks, with which the search for near trunks is quick (ours)."""

from __future__ import annotations

from typing import Protocol

import numpy as np
import numpy.typing as npt

from riot.kernels.leaves import features, gather
from riot.parameters import QcrsParameters
from riot.types import FloatArray, IntArray
from riot.units import D_C


class RaggedTrunks(Protocol):
    """Trunks of any numbers of corners, concatenated: one shape's (`riot.scores.trunks.Trunks`) or many shapes'."""

    @property
    def offsets(self) -> IntArray:
        """(t + 1,) of every trunk's corners in the following three."""

    @property
    def edges(self) -> FloatArray:
        """(s,) edge lengths."""

    @property
    def alphas(self) -> FloatArray:
        """(s,) trunk angles α."""

    @property
    def betas(self) -> FloatArray:
        """(s,) β = 2π − θ − α."""

    @property
    def areas(self) -> FloatArray:
        """(t,) trunk areas."""


def gather_leaves(trunks: RaggedTrunks, kinds: IntArray | None = None) -> npt.NDArray[np.int32]:
    """(l, 16) numbers of similar trunks of one n, in order of n: the leaves of the search (ours).

    With ``kinds`` (t,) a leaf has trunks of one kind, too, and leaves are in order of n and kind.

    >>> from riot.scores.trunks import quick_trunks
    >>> gather_leaves(quick_trunks(house)).shape[1]
    16
    """
    usual = QcrsParameters()
    sizes = np.diff(trunks.offsets)
    kinds = np.zeros(len(sizes), dtype=np.int64) if kinds is None else kinds
    order = np.lexsort((kinds, sizes))
    values = features(trunks.offsets, trunks.edges, trunks.alphas, trunks.betas, trunks.areas)
    sigmas = usual.sigma_e * D_C, usual.sigma_angle, usual.sigma_area
    return gather(values, order, sizes[order], kinds[order], *sigmas)

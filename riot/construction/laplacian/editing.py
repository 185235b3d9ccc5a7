"""Two-dimensional Laplacian editing of a polyline (Sorkine et al., *Laplacian Surface Editing*, 2004; paper §4.3).

A vertex's Laplacian coordinate is its offset from the middle of its two neighbours. Editing keeps these coordinates in
the least-squares sense, each turned and scaled by the similarity that fits the vertex and its neighbours best before
and after; that similarity is itself linear in the new positions, so that one linear system does it.
Ours, where Sorkine et al. leave a choice: handles are met exactly instead of at a weight; the ends have one neighbour
and no coordinate; weights are uniform. Complex numbers make it one banded system, five diagonals wide.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from riot.kernels.laplacian import ComplexArray, factored, solved
from riot.types import BoolArray, FloatArray


@dataclass(frozen=True, eq=False)
class Editing:
    """A polyline at rest with some of its vertices as handles, factored.

    Parameters
    ----------
    rest : (m,) complex128
        Points as x + iy.
    handles : (m,) bool
        The vertices whose positions are given; two at least, else the polyline is free to turn.
    bands, factors : (m, 3) complex128
        Of the normal equations; see `riot.kernels.laplacian.factored`.
    """

    rest: ComplexArray
    handles: BoolArray
    bands: ComplexArray
    factors: ComplexArray

    @classmethod
    def of(cls, rest: ComplexArray, handles: BoolArray) -> Editing:
        """Factor; copies neither array."""
        return cls(rest, handles, *factored(rest, handles))

    def displace(self, moves: ComplexArray) -> ComplexArray:
        """(m,) how far every vertex goes when the handles go as far as ``moves`` (m,) says of them, exactly."""
        return solved(self.bands, self.factors, self.handles, moves)


def edit(curve: FloatArray, handles: BoolArray, targets: FloatArray) -> FloatArray:
    """Edit an open polyline (m, 2): its ``handles`` (m,) bool go to those rows of ``targets`` (m, 2).

    Returns (m, 2). Handles moved by a similarity of the plane move the whole polyline by it; handles left where they
    are leave the polyline as it is, to the last bit. Raises ValueError for fewer than two handles.

    >>> line = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]])
    >>> edit(line, np.array([True, False, True]), line + [0.0, 1.0]).round(9).tolist()
    [[0.0, 1.0], [1.0, 1.0], [2.0, 1.0]]
    """
    if np.count_nonzero(handles) < 2:
        raise ValueError("editing needs two handles at least: with fewer the polyline is free to turn")
    rest, wanted = as_complex(curve), as_complex(targets)
    moves = np.where(handles, wanted - rest, 0.0)
    edited = rest + Editing.of(rest, np.array(handles, dtype=np.bool_)).displace(moves)
    return as_points(np.where(handles, wanted, edited))


def as_complex(points: FloatArray) -> ComplexArray:
    """(m, 2) points as x + iy, (m,).

    >>> as_complex(np.array([[1.0, 2.0], [3.0, 4.0]])).tolist()
    [(1+2j), (3+4j)]
    """
    values: ComplexArray = points[:, 0] + 1j * points[:, 1]
    return values


def as_points(values: ComplexArray) -> FloatArray:
    """The way back: (m, 2).

    >>> as_points(np.array([1.0 + 2.0j, 3.0 + 4.0j])).tolist()
    [[1.0, 2.0], [3.0, 4.0]]
    """
    return np.column_stack([values.real, values.imag])

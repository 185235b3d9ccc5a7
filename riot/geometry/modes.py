"""The elastic modes of a shape: how its interior bends most easily (theory §12, ours).

The energy of a displacement u is E(u) = ∫ |ε(u)|² dA with ε the symmetric part of ∇u, without a Poisson term, plus that
of straight sides which do not stay so (`riot.geometry.sides`). Modes are the displacements of least energy for their
mean square, after the three rigid motions: the lowest generalised eigenvectors of stiffness against mass. The modes of
a shape with limbs move limbs: to bend a leg is cheap, to squash a belly is not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt
import shapely
from scipy.linalg import eigh
from scipy.sparse import csc_array, csr_array
from scipy.sparse.linalg import splu

from riot.geometry.elements import MASS, Elements, elements_on
from riot.geometry.shape import Shape
from riot.geometry.sides import Sides, side_rows, straight_sides
from riot.geometry.triangulation import triangulate
from riot.types import FloatArray, IntArray

SHIFT = 1e-3
"""Mass that is added to the stiffness, so that it has an inverse: less than the eigenvalues of thin limbs."""

BLOCK = 6
"""Vectors that are iterated together, more than eigenvalues of a symmetric shape coincide."""

SETTLED = 1e-3
"""The iteration ends when no eigenvalue changes by a greater share; each is then ten times as near to its limit."""

MARGIN = 8
"""The first test of that is made with so many more vectors than modes."""

MOST_BLOCKS = 40
"""Blocks at most; some nine are usual."""

SINGLE_THREAD = 200_000
"""Multiplications of a matrix product that OpenBLAS, numpy's, does in one thread."""

Regions = Sequence[tuple[npt.ArrayLike, float]]
"""Polygons (m, 2) in the shape's frame, and by which factor the interior is stiffer there."""


@dataclass(frozen=True, eq=False)
class Modes:
    """The softest bending modes of a shape.

    Parameters
    ----------
    shape : Shape
    elements : Elements
        The finite elements on its interior.
    eigenvalues : (K,) float64
        Energy of each mode, ascending.
    vectors : (K, k, 2) float64
        Displacement of the elements' nodes; of unit mean square over the interior.
    stiffness : (t,) float64
        Factor of the energy on each triangle.
    straight : float
        Weight of the energy of straight sides.
    sides : Sides
        The straight sides, by index into ``elements.boundary``.
    """

    shape: Shape
    elements: Elements
    eigenvalues: FloatArray
    vectors: FloatArray
    stiffness: FloatArray
    straight: float
    sides: Sides

    @cached_property
    def outline_weights(self) -> tuple[IntArray, FloatArray]:
        """Six nodes (m, 6) and their weights (m, 6) for each of the shape's outline points."""
        return self.elements.weights(self.shape.points)

    @cached_property
    def displacements(self) -> FloatArray:
        """(K, m, 2) displacement of the shape's outline points."""
        return self.at(self.shape.points)

    @cached_property
    def slopes(self) -> FloatArray:
        """(K, 3 t, 2, 2) displacement gradients ∂u_x/∂y at three points of each triangle."""
        count, triangles = len(self.vectors), self.elements.triangles
        slopes = np.einsum("tqay,ktax->ktqxy", self.elements.gradients, self.vectors[:, triangles])
        return np.asarray(slopes.reshape(count, 3 * len(triangles), 2, 2))

    @cached_property
    def bends_of_sides(self) -> FloatArray:
        """(r, K) the rows of the energy of straight sides, by mode."""
        boundary = self.elements.boundary
        vertices, vectors = side_rows(self.elements.nodes[boundary], self.sides)
        rows = np.einsum("rax,krax->rk", vectors, self.vectors[:, boundary[vertices]])
        return np.asarray(np.sqrt(self.straight) * rows)

    def at(self, points: FloatArray) -> FloatArray:
        """(K, m, 2) displacement of ``points`` (m, 2) of the interior or near it.

        >>> bend = modes(house)
        >>> bend.at(house.points[:3]).shape
        (16, 3, 2)
        """
        nodes, weights = self.elements.weights(points)
        return np.asarray(np.einsum("ma,kmax->kmx", weights, self.vectors[:, nodes]))


def modes(shape: Shape, count: int = 16, straight: float = 0.0, stiffer: Regions = ()) -> Modes:
    """The ``count`` softest modes of a shape (theory §12, ours).

    ``straight`` weighs the energy of straight sides that bend and of right angles that change; ``stiffer`` are regions
    to keep. The same shape gives the same bits on one machine. Raises SilhouetteError ``degenerate`` as
    `riot.geometry.triangulation.triangulate`.

    >>> bend = modes(house, 4)
    >>> bool((np.diff(bend.eigenvalues) >= 0).all())
    True
    """
    elements = elements_on(triangulate(shape.points))
    stiffness = np.ones(len(elements.triangles))
    for polygon, factor in stiffer:
        region = shapely.Polygon(np.asarray(polygon, dtype=np.float64))
        shapely.prepare(region)
        stiffness[shapely.contains_xy(region, elements.middles)] *= factor
    sides = straight_sides(elements.nodes[elements.boundary])
    eigenvalues, vectors = solve_modes(elements, count, stiffness, straight, sides)
    return Modes(shape, elements, eigenvalues, vectors, stiffness, straight, sides)


def solve_modes(
    elements: Elements, count: int, stiffness: FloatArray, straight: float, sides: Sides
) -> tuple[FloatArray, FloatArray]:
    """Eigenvalues (K,) and node displacements (K, k, 2) of the softest modes on finite elements.

    Arguments as in `Modes`. Block Lanczos with shift and inversion, orthogonal to rigid motions, from fixed vectors.

    >>> bend = modes(house, 4)
    >>> eigenvalues, _ = solve_modes(bend.elements, 4, 10.0 * bend.stiffness, 0.0, bend.sides)
    >>> (eigenvalues / bend.eigenvalues).round(3).tolist()
    [10.0, 10.0, 10.0, 10.0]
    """
    stiff, mass = _matrices(elements, stiffness, straight, sides)
    k = len(elements.nodes)
    factors = splu(stiff, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})

    def weighed(vectors: FloatArray) -> FloatArray:
        return np.asfortranarray(np.concatenate([mass @ vectors[:k], mass @ vectors[k:]]))

    rigid = np.zeros((2 * k, 3))
    rigid[:k, 0] = rigid[k:, 1] = 1.0
    rigid[:k, 2], rigid[k:, 2] = -elements.nodes[:, 1], elements.nodes[:, 0]
    most = min(MOST_BLOCKS, (2 * k - 3) // BLOCK)
    basis, duals = (np.empty((2 * k, 3 + BLOCK * most), order="F") for _ in range(2))
    projected = np.zeros((3 + BLOCK * most, 3 + BLOCK * most))
    basis[:, :3] = rigid @ np.linalg.inv(np.linalg.cholesky(_inner(rigid, weighed(rigid)))).T
    duals[:, :3] = weighed(basis[:, :3])
    vectors = factors.solve(weighed(np.random.default_rng(0).standard_normal((2 * k, BLOCK))))
    size, before = 3, np.full(count, np.inf)
    for _ in range(most):
        for _ in range(2):  # once is not enough: what is cancelled leaves its rounding
            vectors = vectors - _product(basis[:, :size], _inner(duals[:, :size], vectors))
        dual = weighed(vectors)
        inverse = np.linalg.inv(np.linalg.cholesky(_inner(vectors, dual))).T
        vectors, dual = _product(vectors, inverse), _product(dual, inverse)
        block = slice(size, size + BLOCK)
        basis[:, block], duals[:, block] = vectors, dual
        size += BLOCK
        vectors = factors.solve(dual)
        projected[:size, block] = _inner(duals[:, :size], vectors)
        if size - 3 >= count + MARGIN:
            values = np.linalg.eigvalsh(projected[3:size, 3:size], UPLO="U")[: -count - 1 : -1]
            if (np.abs(values - before) <= SETTLED * values).all():
                break
            before = values
    # Not numpy's eigh, which has threads wait for each other.
    values, combined = eigh(projected[3:size, 3:size], lower=False, driver="evr")
    softest = _product(basis[:, 3:size], combined[:, : -count - 1 : -1])
    # What is left of the iteration's error is taken out of the energies of sums: they are those of single modes.
    energies = _inner(softest, np.asfortranarray(stiff @ softest))
    values, combined = eigh(0.5 * (energies + energies.T))
    softest = _product(softest, combined)
    # A mode's sign is free: the first of its largest components is positive.
    largest = np.abs(softest) > (1.0 - 1e-6) * np.abs(softest).max(axis=0)
    softest *= np.sign(softest[largest.argmax(axis=0), np.arange(count)])
    return np.asarray(values - SHIFT), np.ascontiguousarray(softest.reshape(2, k, count).transpose(2, 1, 0))


def _inner(a: FloatArray, b: FloatArray) -> FloatArray:
    """aᵀ b of tall matrices, in products so small that BLAS does not share them out among threads.

    The sums then do not depend on the number of threads, nor do threads wait for each other in so short a work.
    """
    rows = max(1, SINGLE_THREAD // (a.shape[1] * b.shape[1]))
    total = a[:rows].T @ b[:rows]
    for start in range(rows, len(a), rows):
        total += a[start : start + rows].T @ b[start : start + rows]
    return total


def _product(a: FloatArray, b: FloatArray) -> FloatArray:
    """a b of a tall and a small matrix, in small products as `_inner`."""
    rows = max(1, SINGLE_THREAD // (b.shape[0] * b.shape[1]))
    product = np.empty((len(a), b.shape[1]), order="F")
    for start in range(0, len(a), rows):
        product[start : start + rows] = a[start : start + rows] @ b
    return product


def _matrices(elements: Elements, stiffness: FloatArray, straight: float, sides: Sides) -> tuple[csc_array, csr_array]:
    """Shifted stiffness of all x and then all y of the nodes, (2 k, 2 k), and mass (k, k)."""
    triangles, areas, k = elements.triangles, elements.areas, len(elements.nodes)
    count = len(triangles)
    mass = areas[:, None, None] * MASS
    slopes = elements.gradients * np.sqrt(stiffness * areas / 3.0)[:, None, None, None]
    slopes = slopes.transpose(0, 1, 3, 2).reshape(count, 3, 12)
    products = slopes.transpose(0, 2, 1) @ slopes
    xx, xy, yy = products[:, :6, :6], products[:, :6, 6:], products[:, 6:, 6:]
    stiff = np.empty((count, 12, 12))
    stiff[:, :6, :6], stiff[:, 6:, 6:] = xx + 0.5 * yy + SHIFT * mass, yy + 0.5 * xx + SHIFT * mass
    stiff[:, :6, 6:], stiff[:, 6:, :6] = 0.5 * xy.transpose(0, 2, 1), 0.5 * xy
    unknowns = np.concatenate([triangles, k + triangles], axis=1)
    entries, rows, columns = [stiff.ravel()], [_rows(unknowns)], [_columns(unknowns)]
    if straight > 0.0 and len(sides.ends):
        vertices, vectors = side_rows(elements.nodes[elements.boundary], sides)
        nodes = elements.boundary[vertices]
        vectors = np.sqrt(straight) * np.concatenate([vectors[..., 0], vectors[..., 1]], axis=1)
        bent = np.concatenate([nodes, k + nodes], axis=1)
        entries.append((vectors[:, :, None] * vectors[:, None, :]).ravel())
        rows.append(_rows(bent))
        columns.append(_columns(bent))
    pairs = np.concatenate(rows), np.concatenate(columns)
    return (
        csc_array((np.concatenate(entries), pairs), shape=(2 * k, 2 * k)),
        csr_array((mass.ravel(), (_rows(triangles), _columns(triangles))), shape=(k, k)),
    )


def _rows(unknowns: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    return np.repeat(unknowns, unknowns.shape[1], axis=1).ravel()


def _columns(unknowns: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    return np.tile(unknowns, (1, unknowns.shape[1])).ravel()

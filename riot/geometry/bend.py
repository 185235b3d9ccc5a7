"""A shape bent along its elastic modes, and the map to it that textures and pins follow (theory §12; ours)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from riot.content import ByContent
from riot.errors import SilhouetteError
from riot.geometry import polyline
from riot.geometry.elements import Elements
from riot.geometry.shape import Shape
from riot.types import FloatArray, IntArray

if TYPE_CHECKING:  # to read a bend from a file takes no modes
    from riot.geometry.modes import Modes

STRAIN_AREA = 0.002
"""Area: the greatest strain is what the strain exceeds on so much and no more. At a concave corner it has no bound, and
what elements have there depends on their size."""

_NEWTON_STEPS = 8
"""Steps at most in which a map is taken back."""

_RELOCATIONS = 2
"""How often the triangle from which a point comes is looked for again."""

_SETTLED = 1e-12
"""Length: a point is taken back when it is met so closely."""


@dataclass(frozen=True, eq=False)
class BendField(ByContent):
    """A continuous map of a shape's interior, of second degree on each triangle.

    Parameters
    ----------
    nodes : (k, 2) float64
        Where corners and edge middles of the triangles lie in the input's frame.
    moved : (k, 2) float64
        Where they go, in the bent shape's frame.
    triangles : (t, 6) int64
        As in `riot.geometry.elements.Elements`.
    """

    nodes: FloatArray
    moved: FloatArray
    triangles: IntArray

    @cached_property
    def _there(self) -> Elements:
        return Elements(self.nodes, self.triangles, np.empty(0, dtype=np.int64))

    @cached_property
    def _back(self) -> Elements:
        return self._there.moved(self.moved)

    def at(self, points: FloatArray) -> FloatArray:
        """Where ``points`` (m, 2) of the input, inside or near it, lie on the bent shape.

        >>> from riot.geometry.modes import modes
        >>> still = bend_shape(modes(house), np.zeros(16))
        >>> bool(np.abs(still.field.at(house.points) - house.points).max() < 1e-9)
        True
        """
        nodes, weights = self._there.weights(points)
        return np.asarray(np.einsum("ma,max->mx", weights, self.moved[nodes]))

    def gradient(self, points: FloatArray) -> FloatArray:
        """(m, 2, 2) derivatives ∂x/∂X of the map at ``points`` (m, 2) of the input.

        >>> from riot.geometry.modes import modes
        >>> still = bend_shape(modes(house), np.zeros(16))
        >>> bool(np.abs(still.field.gradient(np.zeros((1, 2))) - np.eye(2)).max() < 1e-9)
        True
        """
        nodes, slopes = self._there.gradient_weights(points)
        return np.asarray(np.einsum("max,may->mxy", self.moved[nodes], slopes))

    def strain(self, points: FloatArray) -> FloatArray:
        """(m,) how much the map stretches or squeezes at ``points`` (m, 2) in the direction where it does so most.

        >>> from riot.geometry.modes import modes
        >>> still = bend_shape(modes(house), np.zeros(16))
        >>> bool(still.field.strain(np.zeros((1, 2)))[0] < 1e-6)
        True
        """
        return greatest_strain(self.gradient(points))

    def back(self, points: FloatArray) -> FloatArray:
        """Where ``points`` (m, 2) of the bent shape, inside or near it, come from on the input.

        >>> from riot.geometry.modes import modes
        >>> still = bend_shape(modes(house), np.zeros(16))
        >>> bool(np.abs(still.field.back(house.points) - house.points).max() < 1e-9)
        True
        """
        triangle, shares = self._back.locate(points)
        source = np.einsum("ms,msx->mx", shares, self.nodes[self.triangles[triangle, :3]])
        # Edges become curved: near one, the triangle that has the point may be another.
        for _ in range(_RELOCATIONS):
            source = self._back_in(triangle, source, points)
            triangle, _ = self._there.locate(source)
        return self._back_in(triangle, source, points)

    def _back_in(self, triangle: IntArray, source: FloatArray, points: FloatArray) -> FloatArray:
        """Where points come from by the polynomials of given triangles, by Newton's steps from ``source`` on."""
        nodes = self.triangles[triangle]
        for _ in range(_NEWTON_STEPS):
            weights, slopes = self._there.weights_in(triangle, source)
            miss = points - np.einsum("ma,max->mx", weights, self.moved[nodes])
            if not (np.abs(miss) > _SETTLED).any():
                break
            gradient = np.einsum("max,may->mxy", self.moved[nodes], slopes)
            source = source + np.linalg.solve(gradient, miss[..., None])[..., 0]
        return np.asarray(source)


@dataclass(frozen=True, eq=False)
class Bend(ByContent):
    """A shape bent a little.

    Parameters
    ----------
    shape, bent : Shape
        Before and after, both of unit area; point i of one is point i of the other.
    coefficients : (K,) float64
        Amplitudes of the shape's modes times the square roots of their eigenvalues: their squares are energies. After a
        large turn these are only the first part of the bend; ``field`` has all of it.
    field : BendField
        The map from the input's frame to the bent shape's.
    rms_strain : float
        Root of the mean square, over the area, of both principal strains together.
    max_strain : float
        The greatest principal strain but for 0.2 % of the area.
    """

    shape: Shape
    bent: Shape
    coefficients: FloatArray
    field: BendField
    rms_strain: float
    max_strain: float


def bend_shape(modes: Modes, coefficients: FloatArray) -> Bend:
    """Bend a shape by amplitudes of its modes, (K,) in units of energy as in `Bend`, and scale it to unit area (ours).

    Raises SilhouetteError ``degenerate`` if nothing of its area is left; that the outline stays simple is for the
    caller to see.

    >>> from riot.geometry.modes import modes
    >>> house.points.shape == bend_shape(modes(house), np.full(16, 0.01)).bent.points.shape
    True
    """
    amplitudes = coefficients / np.sqrt(modes.eigenvalues)
    nodes = modes.elements.nodes + np.einsum("k,kax->ax", amplitudes, modes.vectors)
    return bent_by(modes, coefficients, nodes)


def bent_by(modes: Modes, coefficients: FloatArray, nodes: FloatArray) -> Bend:
    """The bend that moves the finite elements' nodes to ``nodes`` (k, 2), up to a common shift and scale.

    >>> from riot.geometry.modes import modes
    >>> bend = modes(house)
    >>> bent_by(bend, np.zeros(16), 3.0 * bend.elements.nodes).max_strain < 1e-6
    True
    """
    outline_nodes, weights = modes.outline_weights
    outline = np.einsum("ma,max->mx", weights, nodes[outline_nodes])
    area = polyline.signed_area(outline)
    if not area > 0.0:
        raise SilhouetteError("degenerate", f"{modes.shape.name or 'the shape'} bends so far that no area is left")
    scale = 1.0 / np.sqrt(area)
    centre = polyline.centroid(outline)
    moved = scale * (nodes - centre)
    bent = replace(modes.shape, points=np.ascontiguousarray(scale * (outline - centre)))
    field = BendField(modes.elements.nodes, moved, modes.elements.triangles)
    gradients = np.einsum("tqay,tax->tqxy", modes.elements.gradients, moved[modes.elements.triangles])
    areas = modes.elements.areas
    energy = float((areas[:, None] / 3.0 * strain_energy(gradients)).sum() / areas.sum())
    strains = greatest_strain(gradients.mean(axis=1))
    return Bend(modes.shape, bent, coefficients, field, float(np.sqrt(energy)), exceeded(strains, areas))


def strain_energy(gradients: FloatArray) -> FloatArray:
    """Sum of the squared principal strains (σ₁ − 1)² + (σ₂ − 1)² of maps with ``gradients`` (…, 2, 2).

    It is |ε|² for a small displacement, and nothing for a turn, however large.

    >>> float(strain_energy(np.array([[0.0, -1.1], [1.0, 0.0]])).round(9))
    0.01
    """
    square = (gradients * gradients).sum(axis=(-2, -1))
    return np.asarray(np.maximum(square - 2.0 * _stretch_sum(gradients, square) + 2.0, 0.0))


def greatest_strain(gradients: FloatArray) -> FloatArray:
    """The greater of |σ₁ − 1| and |σ₂ − 1| of maps with ``gradients`` (…, 2, 2).

    >>> float(greatest_strain(np.array([[0.0, -1.1], [0.8, 0.0]])).round(9))
    0.2
    """
    square = (gradients * gradients).sum(axis=(-2, -1))
    total = _stretch_sum(gradients, square)
    apart = np.sqrt(np.maximum(2.0 * square - total * total, 0.0))
    return np.asarray(np.maximum(np.abs(0.5 * (total + apart) - 1.0), np.abs(0.5 * (total - apart) - 1.0)))


def exceeded(strains: FloatArray, areas: FloatArray) -> float:
    """The strain that is exceeded on `STRAIN_AREA` of the area and no more.

    >>> exceeded(np.array([0.1, 9.0, 0.2]), np.array([0.5, 0.001, 0.499]))
    0.2
    """
    order = np.argsort(-strains, kind="stable")
    beyond = np.searchsorted(np.cumsum(areas[order]), STRAIN_AREA * areas.sum(), side="right")
    return float(strains[order[min(beyond, len(order) - 1)]])


def _stretch_sum(gradients: FloatArray, square: FloatArray) -> FloatArray:
    """σ₁ + σ₂, where σ₂ is negative if the map turns the inside out."""
    turned = gradients[..., 0, 0] * gradients[..., 1, 1] - gradients[..., 0, 1] * gradients[..., 1, 0]
    return np.asarray(np.sqrt(np.maximum(square + 2.0 * turned, 0.0)))

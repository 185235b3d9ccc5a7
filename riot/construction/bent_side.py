"""One shape while it is bent: outline, strain, straight sides, and derivatives by its modes (theory §12; ours)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from riot.construction.tuning import LEAST_KEPT_AREA, SOFTEST
from riot.geometry.bend import exceeded, greatest_strain, strain_energy
from riot.geometry.modes import Modes, solve_modes
from riot.geometry.sides import side_rows
from riot.types import FloatArray, IntArray

_LEAST_STRETCH = 1e-12
"""Squared sum of the principal stretches below which a map has no turn; nothing that is bent comes near."""


@dataclass(frozen=True, eq=False)
class BentSide:
    """A shape's outline and interior, ready to be bent from where they are.

    Amplitudes a (K,) are c √(μ + `SOFTEST`) for the coefficient c of a mode with eigenvalue μ: of a stiff mode a² is
    the energy, and no mode moves far by a small amplitude, however soft it is.

    Parameters
    ----------
    modes : Modes
        Those of the input.
    outline_weights : (m, 6) int64 and (m, 6) float64
        Each outline point as a weighted sum of nodes of the finite elements.
    nodes : (k, 2) float64
        Where the nodes are.
    node_moves : (K, k, 2) float64
        How they move by each amplitude.
    outline : (m, 2) float64
    moves : (K, m, 2) float64
        The same for the outline.
    gradients : (q, 2, 2) float64
        Of the map from the input to the interior as it is, at three points of each triangle.
    slopes : (K, q, 2, 2) float64
        How these change by each amplitude.
    sides : (r,) float64
        By how much the input's straight sides are bent already: the rows of their energy.
    side_slopes : (r, K) float64
        How these change by each amplitude.
    """

    modes: Modes
    outline_weights: tuple[IntArray, FloatArray]
    nodes: FloatArray
    node_moves: FloatArray
    outline: FloatArray
    moves: FloatArray
    gradients: FloatArray
    slopes: FloatArray
    sides: FloatArray
    side_slopes: FloatArray

    @classmethod
    def unbent(cls, modes: Modes, outline: FloatArray) -> BentSide:
        """The input with an outline (m, 2), which may have more points than the shape's.

        >>> from riot.geometry.modes import modes
        >>> side = BentSide.unbent(modes(house), house.points)
        >>> abs(side.energy(np.zeros(16), 1.0)[0]) < 1e-12
        True
        """
        unit = 1.0 / np.sqrt(modes.eigenvalues + SOFTEST)
        moves = modes.vectors * unit[:, None, None]
        rows = modes.bends_of_sides * unit
        of_shape = outline is modes.shape.points
        weights = modes.outline_weights if of_shape else modes.elements.weights(outline)
        return cls._on(modes, weights, modes.elements.nodes, moves, np.zeros(len(rows)), rows)

    def bent_again(self, amplitudes: FloatArray) -> BentSide:
        """The side bent by ``amplitudes``, with the softest modes of the shape that it has then.

        >>> from riot.geometry.modes import modes
        >>> side = BentSide.unbent(modes(house), house.points).bent_again(np.full(16, 0.01))
        >>> side.energy(np.zeros(16), 1.0)[0] > 0.001
        True
        """
        _, scale = self.scaled_outline(amplitudes)
        nodes = scale * self.nodes_at(amplitudes)
        modes = self.modes
        elements = modes.elements.moved(nodes)
        values, vectors = solve_modes(elements, len(amplitudes), modes.stiffness, modes.straight, modes.sides)
        moves = vectors / np.sqrt(values + SOFTEST)[:, None, None]
        sides = self.sides + self.side_slopes @ amplitudes
        boundary = elements.boundary
        vertices, rows = side_rows(elements.nodes[boundary], modes.sides)
        side_slopes = np.sqrt(modes.straight) * np.einsum("rax,krax->rk", rows, moves[:, boundary[vertices]])
        return self._on(modes, self.outline_weights, nodes, moves, sides, side_slopes)

    @classmethod
    def _on(
        cls,
        modes: Modes,
        outline_weights: tuple[IntArray, FloatArray],
        nodes: FloatArray,
        moves: FloatArray,
        sides: FloatArray,
        side_slopes: FloatArray,
    ) -> BentSide:
        elements, (around, weights) = modes.elements, outline_weights
        count, triangles = len(moves), elements.triangles
        slopes = np.einsum("tqay,ktax->ktqxy", elements.gradients, moves[:, triangles])
        return cls(
            modes,
            outline_weights,
            nodes,
            moves,
            np.einsum("ma,max->mx", weights, nodes[around]),
            np.ascontiguousarray(np.einsum("ma,kmax->kmx", weights, moves[:, around])),
            np.einsum("tqay,tax->tqxy", elements.gradients, nodes[triangles]).reshape(-1, 2, 2),
            np.ascontiguousarray(slopes).reshape(count, -1, 2, 2),
            sides,
            side_slopes,
        )

    def is_unfolded(self, amplitudes: FloatArray) -> bool:
        """Whether every triangle keeps a share of its area when the side is bent, so that modes can be computed anew.

        >>> from riot.geometry.modes import modes
        >>> BentSide.unbent(modes(house), house.points).is_unfolded(np.zeros(16))
        True
        """
        elements = self.modes.elements
        areas = elements.moved(self.nodes_at(amplitudes)).areas
        return bool((areas > LEAST_KEPT_AREA * elements.areas).all())

    def nodes_at(self, amplitudes: FloatArray) -> FloatArray:
        """(k, 2) the nodes of the finite elements, bent but not scaled.

        >>> from riot.geometry.modes import modes
        >>> bend = modes(house)
        >>> bool((BentSide.unbent(bend, house.points).nodes_at(np.zeros(16)) == bend.elements.nodes).all())
        True
        """
        return np.asarray(self.nodes + np.tensordot(amplitudes, self.node_moves, 1))

    def scaled_outline(self, amplitudes: FloatArray) -> tuple[FloatArray, float]:
        """The bent outline (m, 2) scaled to unit area, and the scale; nan if it has no area.

        >>> from riot.geometry.modes import modes
        >>> _, scale = BentSide.unbent(modes(house), house.points).scaled_outline(np.zeros(16))
        >>> round(scale, 9)
        1.0
        """
        bent = self.outline + np.tensordot(amplitudes, self.moves, 1)
        following = np.concatenate([bent[1:], bent[:1]])
        area = 0.5 * float((bent[:, 0] * following[:, 1] - bent[:, 1] * following[:, 0]).sum())
        scale = 1.0 / np.sqrt(area) if area > 0.0 else np.nan
        return scale * bent, float(scale)

    def by_amplitudes(self, outline: FloatArray, scale: float, gradient: FloatArray, by_scale: float) -> FloatArray:
        """The gradient by amplitudes (K,), of that by the scaled outline's points (m, 2) and by the scale itself.

        >>> from riot.geometry.modes import modes
        >>> side = BentSide.unbent(modes(house), house.points)
        >>> side.by_amplitudes(house.points, 1.0, np.zeros_like(house.points), 0.0).shape
        (16,)
        """
        # scale = area^(−1/2), and the area of the bent outline is 1 / scale².
        total = by_scale + float((gradient * outline).sum()) / scale
        across = np.concatenate([outline[1:], outline[:1]]) - np.concatenate([outline[-1:], outline[:-1]])
        by_area = 0.5 / scale * np.stack([across[:, 1], -across[:, 0]], axis=1)
        pull = scale * gradient - 0.5 * scale**3 * total * by_area
        return np.asarray(np.tensordot(self.moves, pull, ([1, 2], [0, 1])))

    def energy(self, amplitudes: FloatArray, scale: float) -> tuple[float, FloatArray, float]:
        """Energy against the input, with its gradient by the amplitudes (K,) and by the scale.

        The strain's is the sum of the squared principal strains, which is |ε|² for small ones and nothing for a turn,
        however large.

        >>> from riot.geometry.modes import modes
        >>> energy, slope, _ = BentSide.unbent(modes(house), house.points).energy(np.full(16, 1e-5), 1.0)
        >>> bool(0.0 < energy < 16e-10)
        True
        """
        unscaled = self.gradients + np.tensordot(amplitudes, self.slopes, 1)
        maps = scale * unscaled
        turned = maps[:, 0, 0] * maps[:, 1, 1] - maps[:, 0, 1] * maps[:, 1, 0]
        square = (maps * maps).sum(axis=(1, 2))
        total = np.sqrt(np.maximum(square + 2.0 * turned, _LEAST_STRETCH))
        weights = np.repeat(self.modes.elements.areas / 3.0 * self.modes.stiffness, 3)
        cofactors = np.stack([maps[:, 1, 1], -maps[:, 1, 0], -maps[:, 0, 1], maps[:, 0, 0]], axis=1).reshape(-1, 2, 2)
        pull = 2.0 * weights[:, None, None] * (maps - (maps + cofactors) / total[:, None, None])
        bends = self.sides + self.side_slopes @ amplitudes
        by_amplitudes = scale * np.tensordot(self.slopes, pull, ([1, 2, 3], [0, 1, 2]))
        return (
            float(weights @ (square - 2.0 * total + 2.0)) + float(bends @ bends),
            np.asarray(by_amplitudes + 2.0 * (bends @ self.side_slopes)),
            float((pull * unscaled).sum()),
        )

    def maps(self, amplitudes: FloatArray) -> FloatArray:
        """(q, 2, 2) gradients of the map from the input to the bent shape of unit area.

        >>> from riot.geometry.modes import modes
        >>> maps = BentSide.unbent(modes(house), house.points).maps(np.zeros(16))
        >>> bool(np.abs(maps - np.eye(2)).max() < 1e-9)
        True
        """
        _, scale = self.scaled_outline(amplitudes)
        return np.asarray(scale * (self.gradients + np.tensordot(amplitudes, self.slopes, 1)))

    def strains(self, amplitudes: FloatArray) -> tuple[float, float]:
        """(rms, greatest) strain against the input, as in `riot.geometry.bend.Bend`; nan if no area is left.

        >>> from riot.geometry.modes import modes
        >>> max(BentSide.unbent(modes(house), house.points).strains(np.zeros(16))) < 1e-6
        True
        """
        maps, areas = self.maps(amplitudes), self.modes.elements.areas
        energy = float((np.repeat(areas / 3.0, 3) @ strain_energy(maps)) / areas.sum())
        by_triangle = maps.reshape(-1, 3, 2, 2).mean(axis=1)
        return float(np.sqrt(energy)), exceeded(greatest_strain(by_triangle), areas)

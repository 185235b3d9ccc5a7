"""Candidate trunks of one shape: convex n-gons inscribed in it (paper §4.1.2)."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import numpy.typing as npt

from riot.content import ByContent, count
from riot.geometry.shape import Shape
from riot.kernels.enumerate import enumerate_convex
from riot.kernels.simplify import TIE
from riot.parameters import QcrsVariant, TrunkParameters
from riot.scores.edges import admissible_edges, exterior_areas, shared_lengths
from riot.scores.ragged import joined, running
from riot.scores.reversibility import Reversibility, cut_off, reversibility
from riot.scores.vertices import (
    Congruency,
    congruency,
    convex_points,
    local_outside_angles,
    passes_visibility,
    sparse_points,
)
from riot.types import BoolArray, FloatArray, IntArray
from riot.units import D_C, L_C


@dataclass(frozen=True, eq=False)
class Trunks(ByContent):
    """The candidate trunks of one shape, ragged, ordered by (n, area, vertices).

    Trunk t has the vertices ``vertices[offsets[t]:offsets[t + 1]]``, counter-clockwise; edge i of a trunk runs from its
    vertex i to the next.

    Parameters
    ----------
    offsets : (t + 1,) int64
    vertices : (s,) int32
        Indices into the shape's ``points``.
    edges : (s,) float64
        Edge lengths, unit-area frame.
    alphas : (s,) float64
        Trunk angles at the vertices, radians.
    thetas : (s,) float64
        Outside angles of the shape at the vertices, radians.
    areas : (t,) float64
        Trunk areas; the shape's is 1.
    """

    offsets: IntArray
    vertices: npt.NDArray[np.int32]
    edges: FloatArray
    alphas: FloatArray
    thetas: FloatArray
    areas: FloatArray

    def __repr__(self) -> str:
        sizes = f", {self.sizes.min()} to {self.sizes.max()} vertices" if len(self) else ""
        return f"Trunks({count(len(self), 'trunk')}{sizes})"

    def __len__(self) -> int:
        return len(self.areas)

    @property
    def sizes(self) -> IntArray:
        """(t,) number of vertices of each trunk."""
        return np.diff(self.offsets)

    @property
    def betas(self) -> FloatArray:
        """(s,) 2π − θ − α: what the conjugate trunk's angle should be (theory §6)."""
        return 2.0 * math.pi - self.thetas - self.alphas

    def of(self, trunk: int) -> IntArray:
        """(n,) vertices of one trunk, indices into the shape's points.

        >>> len(trunks(house).of(0))
        3
        """
        return self.vertices[self.offsets[trunk] : self.offsets[trunk + 1]].astype(np.int64)

    def of_sizes(self, least: int, most: int) -> Trunks:
        """The trunks with ``least`` to ``most`` vertices, in the same order.

        >>> candidates = trunks(house)
        >>> set(candidates.of_sizes(4, 5).sizes.tolist()) <= {4, 5}
        True
        """
        kept = (self.sizes >= least) & (self.sizes <= most)
        of_kept = np.repeat(kept, self.sizes)
        arrays = {name: getattr(self, name)[of_kept] for name in ("vertices", "edges", "alphas", "thetas")}
        return Trunks(offsets=running(self.sizes[kept]), areas=self.areas[kept], **arrays)

    def to_arrays(self) -> dict[str, npt.NDArray[Any]]:
        """Plain arrays by field name.

        >>> sorted(trunks(house).to_arrays())
        ['alphas', 'areas', 'edges', 'offsets', 'thetas', 'vertices']
        """
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, npt.NDArray[Any]]) -> Trunks:
        """Undo `to_arrays`.

        >>> Trunks.from_arrays(trunks(house).to_arrays()) == trunks(house)
        True
        """
        return cls(**{field.name: arrays[field.name] for field in fields(cls)})


def trunks(shape: Shape, parameters: TrunkParameters | None = None) -> Trunks:
    """The candidate trunks of a shape for the full score; the same as `full_trunks`.

    >>> from riot import Shape
    >>> square = Shape.from_polygon([(0, 0), (1, 0), (1, 1), (0, 1)])
    >>> candidates = trunks(square)
    >>> square.points[candidates.of(0)].shape  # the corners of the first
    (3, 2)
    """
    return full_trunks(shape, parameters)


def quick_trunks(shape: Shape, parameters: TrunkParameters | None = None, necks: Reversibility | None = None) -> Trunks:
    """Candidate trunks without congruency tests, local outside angles, for QCRS (paper §5.2).

    Points cut off by necks narrower than ``neck_width`` are left out; without ``necks``, `reversibility` finds them. A
    shape may have no trunks.

    >>> len(quick_trunks(house)) > 0
    True
    """
    parameters = parameters or TrunkParameters()
    candidates = sparse_points(shape, parameters)
    necks = necks or reversibility(shape)
    candidates = candidates[~cut_off(shape, necks, parameters.neck_width * D_C)[candidates]]
    candidates = candidates[passes_visibility(shape, candidates)]
    convex = convex_points(shape, parameters)
    admissible = admissible_edges(shape, candidates, parameters, convex)
    thetas = local_outside_angles(shape, candidates, parameters)
    return _assemble(shape, candidates, thetas, admissible, len(convex), parameters)


def full_trunks(shape: Shape, parameters: TrunkParameters | None = None) -> Trunks:
    """Candidate trunks with visibility and congruency tests, robust outside angles, for CRS (paper §4.1).

    A shape may have none.

    >>> len(full_trunks(house)) > 0
    True
    """
    parameters = parameters or TrunkParameters()
    candidates = sparse_points(shape, parameters)
    candidates = candidates[passes_visibility(shape, candidates)]
    congruent = congruency(shape, candidates, parameters)
    kept = congruent.score > parameters.tau_c
    candidates = candidates[kept]
    congruent = Congruency(congruent.score[kept], congruent.length[kept], congruent.turn[kept])
    convex = convex_points(shape, parameters)
    admissible = admissible_edges(shape, candidates, parameters, convex)
    admissible &= shared_lengths(shape, candidates, congruent.length) < (parameters.max_overlap - TIE) * L_C
    return _assemble(shape, candidates, congruent.turn, admissible, len(convex), parameters)


def compared_trunks(
    shape: Shape,
    variant: QcrsVariant,
    parameters: TrunkParameters | None = None,
    necks: Callable[[], Reversibility] | None = None,
) -> Trunks:
    """The trunks of a shape that QCRS compares.

    ``paper``: quick trunks (§5.2). ``tuned``: full trunks (§4.1), so that both scores choose among the same trunks,
    with the same outside angles (ours). ``necks`` is called by the paper variant alone, instead of `reversibility`.

    >>> len(compared_trunks(house, "tuned")) == len(full_trunks(house))
    True
    """
    if variant == "tuned":
        return full_trunks(shape, parameters)
    return quick_trunks(shape, parameters, None if necks is None else necks())


def _assemble(
    shape: Shape,
    candidates: IntArray,
    thetas: FloatArray,
    admissible: BoolArray,
    most: int,
    parameters: TrunkParameters,
) -> Trunks:
    """All trunks of up to ``most`` vertices over the admissible edges."""
    points = shape.points[candidates]
    exterior = exterior_areas(shape.points, candidates)
    groups = []
    allowed = parameters.max_trunks
    for n in range(3, min(most, parameters.max_vertices) + 1):
        chosen, longer = enumerate_convex(points, admissible, n, allowed + 1)
        if len(chosen) > allowed:
            break
        allowed -= len(chosen)
        if len(chosen):
            groups.append(_describe(points, exterior, candidates, thetas, chosen))
        if not longer:
            break
    return _join(groups)


def _describe(
    points: FloatArray, exterior: FloatArray, candidates: IntArray, thetas: FloatArray, chosen: IntArray
) -> Trunks:
    """The trunks with one n, given as rows of candidate numbers in lexicographic order."""
    following = np.concatenate([chosen[:, 1:], chosen[:, :1]], axis=1)
    areas = 1.0 - exterior[chosen, following].sum(axis=1)
    order = np.argsort(areas, kind="stable")
    chosen, following = chosen[order], following[order]
    x, y = points[:, 0][chosen], points[:, 1][chosen]
    ahead_x, ahead_y = points[:, 0][following] - x, points[:, 1][following] - y
    behind_x = np.concatenate([-ahead_x[:, -1:], -ahead_x[:, :-1]], axis=1)
    behind_y = np.concatenate([-ahead_y[:, -1:], -ahead_y[:, :-1]], axis=1)
    alphas = np.arctan2(ahead_x * behind_y - ahead_y * behind_x, ahead_x * behind_x + ahead_y * behind_y)
    rows, n = chosen.shape
    return Trunks(
        offsets=np.arange(rows + 1, dtype=np.int64) * n,
        vertices=candidates[chosen].astype(np.int32).ravel(),
        edges=np.hypot(ahead_x, ahead_y).ravel(),
        alphas=alphas.ravel(),
        thetas=thetas[chosen].ravel(),
        areas=areas[order],
    )


def _join(groups: list[Trunks]) -> Trunks:
    sizes = np.concatenate([np.zeros(0, dtype=np.int64), *(group.sizes for group in groups)])
    return Trunks(
        offsets=running(sizes),
        vertices=joined(groups, "vertices", np.int32),
        edges=joined(groups, "edges"),
        alphas=joined(groups, "alphas"),
        thetas=joined(groups, "thetas"),
        areas=joined(groups, "areas"),
    )

"""The solids of a puzzle's parts: the layers of a design, extruded and made one (manifold3d). Ours."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import manifold3d
import numpy as np
import shapely

from riot.fabricate.layers import rings_slabs
from riot.fabricate.model import Design, Slab, polygons
from riot.fabricate.outlines import disc
from riot.types import FloatArray, IntArray

SLIVER = 1e-7
"""Area in mm² of what two layers share by rounding only."""


@dataclass(frozen=True, eq=False)
class Part:
    """A part of the puzzle, and how many of it there are.

    Parameters
    ----------
    name : str
        As in file names: ``piece-1``, ``pin``, ``sleeve``.
    kind : "piece", "pin" or "sleeve"
    count : int
    slabs : tuple of Slab
        Its layers, from the design.
    solid : manifold3d.Manifold
        In mm; a piece in its own frame, the others around the z-axis, all from z = 0 up.
    """

    name: str
    kind: Literal["piece", "pin", "sleeve"]
    count: int
    slabs: tuple[Slab, ...]
    solid: manifold3d.Manifold

    @property
    def volume(self) -> float:
        """Of the solid, mm³."""
        return float(self.solid.volume())

    @property
    def size(self) -> tuple[float, float, float]:
        """Of the box around it, mm."""
        box = self.solid.bounding_box()
        return box[3] - box[0], box[4] - box[1], box[5] - box[2]

    def mesh(self) -> tuple[FloatArray, IntArray]:
        """(v, 3) points in mm and (f, 3) triangles, counter-clockwise seen from outside.

        In an order that depends on the solid alone: points by x, y, z, triangles by their points.
        """
        mesh = self.solid.to_mesh64()
        points = np.array(mesh.vert_properties[:, :3], dtype=np.float64)
        triangles = np.array(mesh.tri_verts, dtype=np.int64)
        order = np.lexsort(points.T[::-1])
        triangles = np.argsort(order)[triangles]
        first = triangles.argmin(axis=1)
        turned = np.take_along_axis(triangles, (first[:, None] + np.arange(3)) % 3, axis=1)
        return points[order], turned[np.lexsort(turned.T[::-1])]


def make_parts(design: Design) -> tuple[Part, ...]:
    """The solids of a design: every piece, the pin, and the sleeve of its telescopic hinges."""
    found = [Part(piece.name, "piece", 1, piece.slabs, extruded(piece.slabs)) for piece in design.pieces]
    for pin in design.pins:
        slab = Slab(0.0, pin.length, disc(0.0, 0.0, 0.5 * pin.diameter))
        found.append(Part("pin", "pin", pin.count, (slab,), extruded((slab,))))
    if design.telescope is not None:
        nested = rings_slabs(design.telescope.sleeve)
        foot = nested[0].low
        slabs = tuple(Slab(slab.low - foot, slab.high - foot, slab.section) for slab in nested)
        found.append(Part("sleeve", "sleeve", design.sleeves, slabs, extruded(slabs)))
    return tuple(found)


def extruded(slabs: tuple[Slab, ...]) -> manifold3d.Manifold:
    """Layers on top of each other as one solid."""
    layers = []
    for slab in slabs:
        rings = [ring for part in polygons(slab.section) for ring in (part.exterior, *part.interiors)]
        contours = [shapely.get_coordinates(ring)[:-1] for ring in rings]
        section = manifold3d.CrossSection(contours, manifold3d.FillRule.EvenOdd)
        layers.append(manifold3d.Manifold.extrude(section, slab.high - slab.low).translate((0.0, 0.0, slab.low)))
    if len(layers) == 1:
        return layers[0]
    return manifold3d.Manifold.batch_boolean(layers, manifold3d.OpType.Add)


def genus(slabs: tuple[Slab, ...]) -> int:
    """Handles of a solid in one part, counted in its flat layers: Euler's number of what they hold and share."""
    euler = sum(_euler(slab.section) for slab in slabs)
    for below, above in pairwise(slabs):
        euler -= _euler(shapely.intersection(below.section, above.section))
    return 1 - euler


def _euler(region: shapely.Geometry) -> int:
    parts = [part for part in polygons(region) if part.area > SLIVER]
    return sum(1 - sum(shapely.Polygon(hole).area > SLIVER for hole in part.interiors) for part in parts)

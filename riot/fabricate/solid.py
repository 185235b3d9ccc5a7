"""The solids of a puzzle's parts: the layers of a design, extruded and made one (manifold3d). Ours."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal

import numpy as np
import shapely

from riot.errors import needs_extra
from riot.fabricate.layers import rings_slabs
from riot.fabricate.model import Design, Slab, polygons
from riot.fabricate.rings import Ring
from riot.fabricate.tuning import SLIVER_MM2
from riot.types import FloatArray, IntArray

with needs_extra("print"):
    import manifold3d


@dataclass(frozen=True, eq=False)
class Part:
    """A part of the puzzle, and how many of it there are.

    Parameters
    ----------
    name : str
        As in file names: ``piece-1``, ``pin``, ``cap``, ``sleeve``.
    kind : "piece", "pin", "cap", "sleeve", "chain" or "tray"
    count : int
    slabs : tuple of Slab
        Its layers, from the design.
    solid : manifold3d.Manifold
        In mm; a piece in its own frame, the others around the z-axis, all from z = 0 up.
    upside_down : bool
        Whether it is printed so.
    """

    name: str
    kind: Literal["piece", "pin", "cap", "sleeve", "chain", "tray"]
    count: int
    slabs: tuple[Slab, ...]
    solid: manifold3d.Manifold
    upside_down: bool = False

    @property
    def printed(self) -> manifold3d.Manifold:
        """The solid as it lies on the printer's bed, z = 0; turned around the x-axis if it is upside down."""
        return self.laid(self.solid)

    def laid(self, solid: manifold3d.Manifold) -> manifold3d.Manifold:
        """A solid of the part's frame as it lies when the part is printed."""
        return solid.rotate((180.0, 0.0, 0.0)).translate((0.0, 0.0, self.size[2])) if self.upside_down else solid

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
        """`mesh_of` the part as it is printed."""
        return mesh_of(self.printed)


def mesh_of(solid: manifold3d.Manifold) -> tuple[FloatArray, IntArray]:
    """(v, 3) points in mm and (f, 3) triangles, counter-clockwise seen from outside.

    In an order that depends on the solid alone: points by x, y, z, triangles by their points.
    """
    mesh = solid.to_mesh64()
    points = np.array(mesh.vert_properties[:, :3], dtype=np.float64)
    triangles = np.array(mesh.tri_verts, dtype=np.int64)
    order = np.lexsort(points.T[::-1])
    triangles = np.argsort(order)[triangles]
    first = triangles.argmin(axis=1)
    turned = np.take_along_axis(triangles, (first[:, None] + np.arange(3)) % 3, axis=1)
    return points[order], turned[np.lexsort(turned.T[::-1])]


def make_parts(design: Design) -> tuple[Part, ...]:
    """The printed parts: every piece, pins or the caps of rods, and the sleeve of its telescopic hinges."""
    parts = [
        Part(piece.name, "piece", 1, piece.slabs, extruded(piece.slabs), piece.upside_down) for piece in design.pieces
    ]
    if design.pivot is not None:
        count = sum(pin.count for pin in design.pins)
        if design.parameters.pivot == "printed":
            parts.append(round_part("pin", count, design.pivot.profile, upside_down=True))
        elif design.parameters.pivot == "rod":
            parts.append(round_part("cap", count, design.pivot.cap, upside_down=True))
    if design.telescope is not None:
        parts.append(round_part("sleeve", design.sleeves, design.telescope.sleeve))
    return tuple(parts)


def round_part(
    kind: Literal["pin", "cap", "sleeve"], count: int, rings: tuple[Ring, ...], *, upside_down: bool = False
) -> Part:
    foot = rings[0].low
    slabs = rings_slabs(tuple(replace(ring, low=ring.low - foot, high=ring.high - foot) for ring in rings))
    return Part(kind, kind, count, slabs, extruded(slabs), upside_down)


def extruded(slabs: tuple[Slab, ...]) -> manifold3d.Manifold:
    """Layers on top of each other as one solid."""
    layers = []
    for slab in slabs:
        rings = [ring for polygon in polygons(slab.section) for ring in (polygon.exterior, *polygon.interiors)]
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
    regions = [polygon for polygon in polygons(region) if polygon.area > SLIVER_MM2]
    return sum(1 - sum(shapely.Polygon(hole).area > SLIVER_MM2 for hole in polygon.interiors) for polygon in regions)


def common_volume(first: manifold3d.Manifold, second: manifold3d.Manifold) -> float:
    """Volume that two solids have in common, mm³."""
    a, b = first.bounding_box(), second.bounding_box()
    if any(a[k] >= b[k + 3] or b[k] >= a[k + 3] for k in range(3)):
        return 0.0
    return float((first ^ second).volume())

"""Inlays: pictures sunk into the front and the back of the pieces, flush, as bodies of other filaments. Ours.

A piece is parted, not added to: its bodies share no volume, and together they are the piece, so that fits, gaps and
overhangs stay as they are certified.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import shapely
from PIL import ImageColor

from riot.draw.palette import PIECES, hue
from riot.draw.texture.names import SIDES
from riot.fabricate.export.drawing import Drawing, depths
from riot.fabricate.export.poses import frames_of
from riot.fabricate.in_place import placing
from riot.fabricate.model import Design, Slab, polygons
from riot.fabricate.solid import Part, extruded, mesh_of
from riot.types import FloatArray, IntArray

if TYPE_CHECKING:
    import manifold3d

    from riot.draw.texture.names import Side
    from riot.draw.texture.source import ByteArray

_ABOVE_MM = 1.0
_NAMES: Mapping[Side, str] = {"p": "front", "q": "back"}


@dataclass(frozen=True, eq=False)
class Body:
    """One body of a piece, as the piece is printed: the ``base``, or an inlay as in ``front-2``, of filament 2."""

    name: str
    filament: int
    colour: str
    solid: manifold3d.Manifold

    @property
    def volume(self) -> float:
        """In mm³."""
        return float(self.solid.volume())

    def mesh(self) -> tuple[FloatArray, IntArray]:
        """See `riot.fabricate.solid.mesh_of`."""
        return mesh_of(self.solid)


def bodies_of(design: Design, part: Part, drawing: Drawing) -> tuple[Body, ...]:
    """The base and the inlays of a part; nothing for a part that has no inlay."""
    piece = next((piece for piece in design.pieces if piece.name == part.name), None)
    if piece is None:
        return ()
    inlays: list[tuple[Side, int, manifold3d.Manifold]] = []
    rest = part.solid
    for side in SIDES:
        regions = drawing.regions[side][piece.index]
        # All are cut out of the whole part: no cut goes along another one.
        for filament, region in enumerate(regions, start=2):
            if not region.is_empty:
                inlays.append((side, filament, part.solid ^ _room(design, side, region)))
        if not all(region.is_empty for region in regions):
            together = shapely.coverage_union_all([polygon for region in regions for polygon in polygons(region)])
            rest -= _room(design, side, together)
    if not inlays:
        return ()
    base = drawing.base or PIECES[hue(piece.index, len(design.pieces))]
    return (
        Body("base", 1, base, part.laid(rest)),
        *(
            Body(f"{_NAMES[side]}-{filament}", filament, drawing.colours[filament - 2], part.laid(inlay))
            for side, filament, inlay in inlays
        ),
    )


def chain_bodies(design: Design, parts: Sequence[Part], bodies: Mapping[str, Sequence[Body]]) -> tuple[Body, ...]:
    """The bodies of a chain that is printed in place, where they lie: those of every piece, or the piece itself."""
    placed = []
    for piece, part in zip(design.pieces, parts, strict=False):
        place, own = placing(design, piece), PIECES[hue(piece.index, len(design.pieces))]
        whole = (Body("", 1, own, part.solid),)
        for body in bodies.get(part.name) or whole:
            name = f"{part.name}-{body.name}".rstrip("-")
            placed.append(replace(body, name=name, solid=body.solid.transform(place)))
    return tuple(placed)


def _room(design: Design, side: Side, region: shapely.Geometry) -> manifold3d.Manifold:
    """The room of an inlay, beyond the face of the piece."""
    low, high = depths(design, side)
    low, high = (low, high + _ABOVE_MM) if side == "p" else (low - _ABOVE_MM, high)
    return extruded((Slab(low, high, region),))


@dataclass(frozen=True, eq=False)
class InlayTexture:
    """How one side of the pieces looks with its inlays; a `riot.draw.texture.paint.Texture`."""

    design: Design
    drawing: Drawing
    side: Side

    def colours(self, piece: int, xy: FloatArray, step: float) -> ByteArray:
        """See `riot.draw.texture.paint.Texture`."""
        del step  # edges are sharp
        pose = self.design.transform.pose(0.0 if self.side == "p" else 1.0)
        points = frames_of(self.design, pose)[piece].piece(self.design.scale * xy)
        pixels = np.empty((len(xy), 3), dtype=np.uint8)
        pixels[:] = ImageColor.getrgb(self.drawing.base or PIECES[hue(piece, len(self.design.pieces))])[:3]
        for colour, region in zip(self.drawing.colours, self.drawing.regions[self.side][piece], strict=True):
            shapely.prepare(region)
            pixels[shapely.contains_xy(region, points)] = ImageColor.getrgb(colour)[:3]
        return pixels

"""What inlays show: lines along the outlines of both shapes, or textures in few colours. Ours."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import shapely
from scipy import ndimage
from shapely import affinity

from riot.draw.palette import LIGHT
from riot.draw.texture.names import SIDES
from riot.draw.texture.sample import sample_region
from riot.fabricate.export.paper import Frame
from riot.fabricate.export.poses import frames_of
from riot.fabricate.export.sheets import face_colours
from riot.fabricate.model import polygons
from riot.fabricate.tuning import GRID_MM, SMOOTHING_MM

if TYPE_CHECKING:
    from riot.draw.texture.names import Side
    from riot.draw.texture.paint import Texture
    from riot.draw.texture.source import ByteArray
    from riot.fabricate.model import Design, PieceDesign
    from riot.types import BoolArray, FloatArray

LINE_MM, INSET_MM = 1.2, 1.6
"""mm: width of the line along an outline, three lines of a nozzle of 0.4 mm, and its distance from the outline."""

MOST_FILAMENTS = 4
"""Filaments of a painted puzzle: as many as the usual changers hold."""

PIXEL_MM, SMOOTHING_PIXELS = 0.2, 1.5
"""mm: step at which textures are sampled; and how far colours of pixels are smoothed, in steps: less than a line."""

ALIKE = 48.0
"""Distance in RGB: colours that are nearer are one, as those of a blended edge; 8 bits a channel."""

LEAST_SHARE = 0.01
"""Share of the painted area: rarer colours are none of the filaments'."""

SIMPLIFIED_PIXELS = 3.0
"""Outlines of regions leave out what is smaller than a triangle of this side, in pixels."""

LEAST_LINE_MM = 0.4
"""mm: nothing of an inlay is narrower; a line of a nozzle of 0.4 mm."""

LEAST_AREA_MM2 = 1.0
"""mm²: no part of an inlay is smaller; it must stick to the bed by itself."""

OVERCUT_MM = 0.01
"""mm: an inlay reaches so far beyond its region, so that no film of the piece is left where it ends at a wall."""

_BIN = 16


@dataclass(frozen=True, eq=False)
class Drawing:
    """Colours of inlays, and which regions of a piece have them.

    Parameters
    ----------
    base : "#rrggbb" or None
        Colour of the pieces' own filament, the first; None: every piece keeps its own.
    colours : tuple of "#rrggbb"
        Of the filaments from the second on.
    regions : for each side, for each piece, for each colour, a region
        In the piece's frame, mm: where the piece is solid as deep as inlays are, and where nothing is too narrow. A
        region that ends at a wall reaches `OVERCUT_MM` beyond it. Regions of a side share no area.
    """

    base: str | None
    colours: tuple[str, ...]
    regions: Mapping[Side, tuple[tuple[shapely.Geometry, ...], ...]]


def drawing_of(design: Design, textures: Mapping[Side, Texture] | None = None) -> Drawing | None:
    """What is sunk into the pieces: ``textures`` in few colours, or lines along the outlines; None without inlays."""
    if not design.parameters.inlay:
        return None
    return painted_drawing(design, textures) if textures else outline_drawing(design)


def depths(design: Design, side: Side) -> tuple[float, float]:
    """Heights between which the inlays of a side are, mm."""
    height, depth = design.parameters.height, design.parameters.inlay
    return (height - depth, height) if side == "p" else (0.0, depth)


def outline_drawing(design: Design) -> Drawing:
    """A line within P's outline on the front, one within Q's on the back, both of the second filament."""
    transform = design.transform
    regions: dict[Side, tuple[tuple[shapely.Geometry, ...], ...]] = {}
    for side, time, outline in zip(SIDES, (0.0, 1.0), (transform.outline_p(), transform.outline_q()), strict=True):
        whole = shapely.Polygon(design.scale * outline)
        line = whole.buffer(-INSET_MM).difference(whole.buffer(-INSET_MM - LINE_MM))
        frames = frames_of(design, transform.pose(time))
        regions[side] = tuple(
            _sunk(design, piece, side, [shapely.transform(line, frame.piece)])
            for piece, frame in zip(design.pieces, frames, strict=True)
        )
    return Drawing(None, (LIGHT["ink"],), regions)


def painted_drawing(design: Design, textures: Mapping[Side, Texture]) -> Drawing:
    """Textures in the colours that they have most of: the first is that of the pieces, the others are sunk.

    A side without a texture stays plain.
    """
    rasters = {
        (side, piece.index): _raster(design, texture, side, piece)
        for side, texture in textures.items()
        for piece in design.pieces
    }
    palette = _palette(np.concatenate([raster.pixels[raster.inside] for raster in rasters.values()]))
    plain = (shapely.Polygon(),) * (len(palette) - 1)
    regions: dict[Side, tuple[tuple[shapely.Geometry, ...], ...]] = {
        side: tuple(
            _sunk(design, piece, side, _regions(rasters[side, piece.index], palette) if side in textures else plain)
            for piece in design.pieces
        )
        for side in SIDES
    }
    base, *others = (f"#{bytes(colour).hex()}" for colour in palette.tolist())
    return Drawing(base, tuple(others), regions)


@dataclass(frozen=True, eq=False)
class _Raster:
    """Colours (rows, columns, 3) of a piece's side, which of them are within, and the upper left corner, mm."""

    pixels: ByteArray
    inside: BoolArray
    left: float
    top: float


def _raster(design: Design, texture: Texture, side: Side, piece: PieceDesign) -> _Raster:
    colours = face_colours(design, texture, side, piece.index, Frame(0.0, 0.0, 0.0), PIXEL_MM)
    region = shapely.Polygon(piece.outline)
    pixels, (left, _, _, top) = sample_region(region, PIXEL_MM, colours)
    rows, columns = pixels.shape[:2]
    x, y = np.meshgrid(left + PIXEL_MM * (np.arange(columns) + 0.5), top - PIXEL_MM * (np.arange(rows) + 0.5))
    shapely.prepare(region)
    return _Raster(pixels, shapely.contains_xy(region, x, y), left, top)


def _palette(pixels: ByteArray) -> ByteArray:
    """The colours that pixels (k, 3) have most of, the most frequent first; no two of them are alike."""
    left = pixels.astype(np.int64)
    found: list[FloatArray] = []
    while len(found) < MOST_FILAMENTS and len(left) > LEAST_SHARE * len(pixels):
        cells, counts = np.unique(left // _BIN, axis=0, return_counts=True)
        peak = left[(left // _BIN == cells[counts.argmax()]).all(axis=1)]
        if found and counts.max() < LEAST_SHARE * len(pixels):
            break
        found.append(np.median(peak, axis=0))
        left = left[np.linalg.norm(left - found[-1], axis=1) > ALIKE]
    return np.rint(found).astype(np.uint8)


def _regions(raster: _Raster, palette: ByteArray) -> tuple[shapely.Geometry, ...]:
    """The region of every colour of the palette but the first, which is that of the rest."""
    distances = np.linalg.norm(raster.pixels[..., None, :].astype(np.float64) - palette, axis=3)
    labels = distances.argmin(axis=2)
    # What is outside takes the colour of the nearest pixel within: regions then end where the piece does.
    rows, columns = ndimage.distance_transform_edt(~raster.inside, return_distances=False, return_indices=True)
    labels = labels[rows, columns]
    shares = [ndimage.gaussian_filter(np.asarray(labels == k, float), SMOOTHING_PIXELS) for k in range(len(palette))]
    labels = np.argmax(shares, axis=0)
    present = np.unique(labels)
    steps = shapely.coverage_simplify([_cells(labels == k) for k in present.tolist()], SIMPLIFIED_PIXELS)
    found = dict(zip(present.tolist(), steps, strict=True))
    to_piece = [PIXEL_MM, 0.0, 0.0, -PIXEL_MM, raster.left, raster.top]
    return tuple(affinity.affine_transform(found.get(k, shapely.Polygon()), to_piece) for k in range(1, len(palette)))


def _cells(inside: BoolArray) -> shapely.Geometry:
    """The pixels of a mask as a region, columns to the right and rows down."""
    padded = np.pad(inside, ((0, 0), (1, 1))).astype(np.int8)
    change = np.diff(padded, axis=1)
    (row, first), (_, last) = np.nonzero(change == 1), np.nonzero(change == -1)
    return shapely.union_all(shapely.box(first, row, last, row + 1))


def _sunk(
    design: Design, piece: PieceDesign, side: Side, drawn: Sequence[shapely.Geometry]
) -> tuple[shapely.Geometry, ...]:
    """What of some regions a piece takes; those that share a line share its points, and no area."""
    low, high = depths(design, side)
    sections = [slab.section for slab in piece.slabs if slab.low < high and low < slab.high]
    solid, taken = shapely.intersection_all(sections), []
    for region in drawn:
        wide = shapely.intersection(region, solid).buffer(-0.5 * LEAST_LINE_MM).buffer(0.5 * LEAST_LINE_MM)
        kept = [polygon for polygon in polygons(wide) if polygon.area >= LEAST_AREA_MM2]
        taken.append(shapely.union_all(kept).buffer(OVERCUT_MM).simplify(SMOOTHING_MM))
    lines = shapely.union_all([region.boundary for region in taken], grid_size=GRID_MM)
    cells = polygons(shapely.polygonize(shapely.get_parts(lines)))
    owned: list[list[shapely.Polygon]] = [[] for _ in drawn]
    for cell in cells:
        owner = next((k for k, region in enumerate(taken) if region.contains(cell.point_on_surface())), None)
        if owner is not None:
            owned[owner].append(cell)
    return tuple(shapely.coverage_union_all(own) if own else shapely.Polygon() for own in owned)

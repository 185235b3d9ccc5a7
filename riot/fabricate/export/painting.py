"""Textures as what inlays show: regions of few colours. Ours."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import shapely
from scipy import ndimage
from shapely import affinity

from riot.draw.texture.names import SIDES
from riot.draw.texture.sample import sample_region
from riot.fabricate.export.drawing import Drawing, sunk
from riot.fabricate.export.faces import face_colours
from riot.fabricate.export.paper import Frame

if TYPE_CHECKING:
    from riot.draw.texture.names import Side
    from riot.draw.texture.paint import Texture
    from riot.draw.texture.source import ByteArray
    from riot.fabricate.model import Design, PieceDesign
    from riot.types import BoolArray, FloatArray

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

_BIN = 16


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
            sunk(design, piece, side, _regions(rasters[side, piece.index], palette) if side in textures else plain)
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

"""The contact sheet: every outline on the picture that it was read from, the doubtful ones first. Ours."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

from pipeline.datasets.item import SAMPLE_PREFIX
from pipeline.report.environment import render
from pipeline.stages.qualities import qualities
from pipeline.stages.shape_arrays import unpack_shape
from pipeline.store.store import write_atomically
from pipeline.tables.record import CHECK, REPORT
from pipeline.tables.results import Results
from riot.geometry.limits import PICTURE_BYTES, SVG_BYTES, check_file
from riot.geometry.picture import PICTURE_FORMATS, upright
from riot.geometry.polyline import simplify
from riot.geometry.quality import ReadingQuality
from riot.geometry.shape import Shape
from riot.geometry.svg_outline import looks_like_svg

SIDE = 160
"""Pixels of the longer side of a picture on the sheet."""

MOST = 3_000
"""Pictures on the sheet; of a larger collection it shows the doubtful ones, and others spread evenly over it."""

_JPEG_QUALITY = 60
_SVG_SHOWN = 100_000
"""Bytes of the greatest SVG file that the sheet shows as it is."""

_PLAIN_LEVELS = 4
"""Pictures with no more colours are kept without loss: that takes fewer bytes."""


@dataclass(frozen=True)
class Tile:
    """A picture on the sheet: its address as a data URI, its size, and the outline in its pixels.

    ``width`` and ``height`` are those of the outline's drawing; ``apart``: it does not lie on the picture.
    """

    name: str
    picture: str
    width: float
    height: float
    outline: str
    quality: ReadingQuality
    apart: bool = False

    @property
    def stroke(self) -> float:
        """Width of the outline, the same on all pictures."""
        return max(self.width, self.height) / SIDE


@dataclass(frozen=True)
class Refused:
    """A picture that cannot be read, and why."""

    name: str
    message: str


def tile(name: str, source: str, shape: Shape) -> Tile:
    """The outline of a shape on its picture, or beside it; alone if the picture cannot be shown."""
    outline = shape.source(shape.points)
    quality = shape.quality or ReadingQuality()
    if source.startswith(SAMPLE_PREFIX):
        return _alone(name, "", outline if shape.to_source[1, 1] < 0 else outline * [1.0, -1.0], quality)
    try:
        if looks_like_svg(source):
            return _alone(name, _svg_uri(Path(source)), outline, quality)
        picture, width, height = _picture_uri(Path(source))
    except Exception:  # it was read before: a sheet without a picture is better than none
        return _alone(name, "", outline, quality)
    # Integers are at the centres of pixels.
    return Tile(name, picture, width, height, _path(outline + 0.5, max(width, height) / SIDE), quality)


def sheet(name: str, tiles: Sequence[Tile], refused: Sequence[Refused], report: str = "") -> str:
    """The page: doubtful outlines, pictures that cannot be read, and all others; ``report`` is the report's address."""
    doubtful = [one for one in tiles if one.quality.doubtful]
    clear = [one for one in tiles if not one.quality.doubtful]
    room = max(0, MOST - len(doubtful))
    shown = clear if len(clear) <= room else [clear[k * len(clear) // room] for k in range(room)]
    return render(
        "check.html", name=name, doubtful=doubtful, clear=clear, shown=shown, refused=refused, report=report, side=SIDE
    )


def write_check(results: Results, folder: Path) -> Path:
    """Write the contact sheet of a run into its folder; returns its path."""
    progress = results.progress
    refused = [Refused(row["item"], row["message"]) for row in results.errors if row["stage"] in ("ingest", "collect")]
    target = folder / CHECK
    write_atomically(target, sheet(progress.collection.name, list(_tiles(results)), refused, REPORT).encode())
    return target


def _tiles(results: Results) -> Iterator[Tile]:
    progress = results.progress
    for batch, item in zip(progress.batches, progress.work["ingest"], strict=True):
        artifact = results.artifact(item)
        if artifact is None:
            continue
        for index, quality in enumerate(qualities(artifact)):
            shape = unpack_shape(artifact, index)
            if shape is not None:
                of = progress.items[batch.start + index]
                known = Shape(shape.points, shape.feature, of.name, shape.to_source, quality)
                yield tile(of.name, of.source, known)


def _alone(name: str, picture: str, outline: np.ndarray, quality: ReadingQuality) -> Tile:
    low, size = outline.min(axis=0), np.ptp(outline, axis=0)
    margin = 0.05 * float(size.max())
    width, height = (size + 2.0 * margin).tolist()
    return Tile(name, picture, width, height, _path(outline - low + margin, max(width, height) / SIDE), quality, True)


def _picture_uri(path: Path) -> tuple[str, int, int]:
    """A small copy of a picture as a data URI, and its own size, upright."""
    check_file(path, PICTURE_BYTES)
    with Image.open(path, formats=PICTURE_FORMATS) as image:
        width, height = image.size
        image.draft("RGB", (2 * SIDE, 2 * SIDE))
        picture = upright(image)
        if picture.size != image.size:  # turned by a quarter
            width, height = height, width
        if picture.mode in ("I", "F", "I;16", "I;16L", "I;16B"):
            values = np.asarray(picture, dtype=np.float64)
            values = np.nan_to_num(values, nan=0.0, posinf=0.0, neginf=0.0)
            spread = max(float(np.ptp(values)), 1e-300)
            picture = Image.fromarray(np.rint((values - values.min()) * (255.0 / spread)).astype(np.uint8))
        small = picture.convert("RGBA")
    small.thumbnail((SIDE, SIDE), Image.Resampling.BOX)
    under = Image.new("RGBA", small.size, (255, 255, 255, 255))
    whole = Image.alpha_composite(under, small).convert("RGB")
    grey = whole.convert("L")
    plain = len(set(grey.tobytes())) <= _PLAIN_LEVELS and grey.convert("RGB").tobytes() == whole.tobytes()
    stream = io.BytesIO()
    if plain:
        grey.save(stream, "PNG")
    else:
        whole.save(stream, "JPEG", quality=_JPEG_QUALITY)
    return _uri("image/png" if plain else "image/jpeg", stream.getvalue()), width, height


def _svg_uri(path: Path) -> str:
    check_file(path, SVG_BYTES)
    data = path.read_bytes()
    return _uri("image/svg+xml", data) if len(data) <= _SVG_SHOWN and data.lstrip()[:1] == b"<" else ""


def _uri(kind: str, data: bytes) -> str:
    return f"data:{kind};base64,{base64.b64encode(data).decode('ascii')}"


def _path(outline: np.ndarray, pixel: float) -> str:
    """An outline as an SVG path, exact to a third of a ``pixel`` of the sheet."""
    kept = outline[simplify(outline, pixel / 3.0)]
    digits = max(0, int(np.ceil(-np.log10(pixel / 3.0)))) if pixel > 0.0 else 2
    points = " ".join(f"{x:.{digits}f},{y:.{digits}f}" for x, y in kept.tolist())
    return f"M{points}Z"

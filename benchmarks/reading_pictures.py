"""How well pictures are read: altered copies of silhouettes, compared with what the originals are read as.

    python benchmarks/reading_pictures.py PICTURES                     a thousand alterations, by kind
    python benchmarks/reading_pictures.py PICTURES --count 200         fewer
    python benchmarks/reading_pictures.py PICTURES --save FILE         digests of the originals' outlines, too
    python benchmarks/reading_pictures.py PICTURES --compare FILE      count the outlines that differ from saved ones

IoU is that of the outline read from the altered copy with the one read from the original, moved as the alteration
moves it. CPU time is that of reading a file, kernels compiled.
"""

from __future__ import annotations

import argparse
import hashlib
import io
import json
import statistics
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import shapely
from PIL import Image, ImageFilter

from riot.cli.table import Table
from riot.errors import SilhouetteError
from riot.geometry.shape import Shape
from riot.geometry.silhouette import read
from riot.types import FloatArray

Alteration = Callable[[FloatArray, np.random.Generator], Image.Image]
RIGHT = 0.97
"""IoU from which an outline counts as right."""

MARGIN = 10


@dataclass(frozen=True)
class Reading:
    """One altered picture: its kind, the IoU, −1 if it was refused, whether it is doubtful, and seconds."""

    kind: str
    iou: float
    doubtful: bool
    seconds: float


def _grey(values: FloatArray) -> Image.Image:
    return Image.fromarray(np.clip(np.rint(values), 0.0, 255.0).astype(np.uint8))


def _coloured(share: FloatArray, ink: FloatArray, page: FloatArray) -> Image.Image:
    return _grey(page + (ink - page) * (share / 255.0)[..., None])


def _opaque(share: FloatArray, alpha: FloatArray) -> Image.Image:
    picture = _grey(share)
    picture.putalpha(_grey(alpha))
    return picture


def _jpeg(picture: Image.Image, rng: np.random.Generator) -> Image.Image:
    stream = io.BytesIO()
    picture.save(stream, "JPEG", quality=int(rng.integers(40, 95)))
    return Image.open(io.BytesIO(stream.getvalue()))


def _across(share: FloatArray) -> tuple[FloatArray, FloatArray]:
    rows, columns = np.indices(share.shape)
    return rows / share.shape[0], columns / share.shape[1]


def _lit(share: FloatArray, light: FloatArray, rng: np.random.Generator) -> Image.Image:
    return _grey(30.0 + (255.0 - share) * 0.8 * light + rng.normal(0.0, 3.0, share.shape))


def _vignette(share: FloatArray, rng: np.random.Generator) -> Image.Image:
    rows, columns = _across(share)
    away = 2.0 * ((rows - 0.5) ** 2 + (columns - 0.5) ** 2)
    return _lit(share, 1.0 - rng.uniform(0.2, 0.8) * away ** rng.uniform(0.8, 1.5), rng)


def _edge(share: FloatArray, rng: np.random.Generator) -> Image.Image:
    alpha = np.full(share.shape, 255.0)
    alpha[0] = alpha[:, -1] = 250.0
    return _opaque(share, alpha)


def _frame(share: FloatArray, rng: np.random.Generator) -> Image.Image:
    width = int(rng.integers(1, 4))
    framed = 255.0 - share
    framed[:width] = framed[-width:] = framed[:, :width] = framed[:, -width:] = 0.0
    return _grey(framed)


def _checks(share: FloatArray, rng: np.random.Generator) -> Image.Image:
    rows, columns = np.indices(share.shape)
    page = np.where((rows // 8 + columns // 8) % 2 == 0, 255.0, 204.0)
    return _coloured(share, np.array(rng.integers(0, 150, 3), dtype=float), page[..., None] * np.ones(3))


KINDS: dict[str, Alteration] = {
    "as it is": lambda share, rng: _grey(share),
    "JPEG": lambda share, rng: _jpeg(_grey(share), rng),
    "noise": lambda share, rng: _grey(share + rng.normal(0.0, rng.uniform(10.0, 60.0), share.shape)),
    "salt and pepper": lambda share, rng: _grey(
        share + 510.0 * rng.choice([-1, 0, 1], share.shape, p=[0.01, 0.98, 0.01])
    ),
    "blur": lambda share, rng: _grey(share).filter(ImageFilter.GaussianBlur(rng.uniform(0.5, 3.0))),
    "inverted": lambda share, rng: _grey(255.0 - share),
    "colours": lambda share, rng: _coloured(share, *rng.integers(0, 256, (2, 3)).astype(float)),
    "colours, JPEG": lambda share, rng: _jpeg(_coloured(share, *rng.integers(0, 256, (2, 3)).astype(float)), rng),
    "equal lightness": lambda share, rng: _coloured(share, np.array([255.0, 0.0, 0.0]), np.array([0.0, 130.0, 0.0])),
    "specks of opacity 254": lambda share, rng: _opaque(share, np.where(rng.random(share.shape) < 0.01, 254.0, 255.0)),
    "edge of opacity 250": _edge,
    "cut out": lambda share, rng: _opaque(rng.integers(0, 256, share.shape).astype(float), share),
    "vignette": _vignette,
    "slope of light": lambda share, rng: _lit(share, 1.0 - rng.uniform(0.2, 0.7) * _across(share)[1], rng),
    "shadow": lambda share, rng: _lit(share, 1.0 - rng.uniform(0.2, 0.6) * np.exp(-10.0 * _across(share)[1]), rng),
    "hot pixels": lambda share, rng: _grey(np.where(rng.random(share.shape) > 0.9995, 255.0, 5.0 + 0.08 * share)),
    "frame": _frame,
    "checkerboard": _checks,
}


def readings(pictures: list[Path], count: int) -> Iterator[Reading]:
    """Alter pictures and read them; the same alterations every time."""
    rng = np.random.default_rng(5)
    kinds = list(KINDS.items())
    with tempfile.TemporaryDirectory() as folder:
        for number in range(count):
            path = pictures[int(rng.integers(len(pictures)))]
            kind, alter = kinds[number % len(kinds)]
            original = read(path)
            truth = shapely.Polygon(original.source(original.points) + MARGIN)
            with Image.open(path) as stored:
                share = np.pad(np.asarray(stored.convert("L"), dtype=np.float64), MARGIN)
            picture = alter(share, rng)
            altered = Path(folder) / ("altered.jpg" if picture.format == "JPEG" else "altered.png")
            if picture.format == "JPEG":
                picture.save(altered, quality="keep")
            else:
                picture.save(altered)
            yield _read(kind, altered, truth)


def _read(kind: str, path: Path, truth: shapely.Polygon) -> Reading:
    started = time.process_time()
    try:
        shape = read(path)
    except SilhouetteError:
        return Reading(kind, -1.0, False, time.process_time() - started)
    seconds = time.process_time() - started
    outline = shapely.Polygon(shape.source(shape.points))
    iou = float(outline.intersection(truth).area / outline.union(truth).area)
    return Reading(kind, iou, shape.quality is not None and shape.quality.doubtful, seconds)


def digest(shape: Shape) -> str:
    """SHA-256 of an outline, its corners and its place."""
    arrays = (shape.points, shape.feature, shape.to_source)
    return hashlib.sha256(b"".join(array.tobytes() for array in arrays)).hexdigest()


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pictures", type=Path, help="folder of silhouettes, light on dark, such as MPEG-7")
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--save", type=Path)
    parser.add_argument("--compare", type=Path)
    chosen = parser.parse_args()
    pictures = sorted(chosen.pictures.rglob("*.png"))
    if chosen.save or chosen.compare:
        started = time.process_time()
        digests = {path.name: digest(read(path)) for path in pictures}
        mean = (time.process_time() - started) / len(pictures)
        print(f"{len(digests)} originals read, {mean * 1e3:.1f} ms each in the mean")
        if chosen.save:
            chosen.save.write_text(json.dumps(digests))
        if chosen.compare:
            saved = json.loads(chosen.compare.read_text())
            print(f"{sum(saved.get(name) != value for name, value in digests.items())} differ from {chosen.compare}")
    found = list(readings(pictures, chosen.count))
    rows = []
    for kind in (*KINDS, "all"):
        of_kind = [reading for reading in found if kind in (reading.kind, "all")]
        if not of_kind:
            continue
        ious = [reading.iou for reading in of_kind]
        rows.append(
            (
                kind,
                str(len(of_kind)),
                f"{statistics.median(ious):.4f}",
                f"{min(ious):.3f}",
                str(sum(iou < RIGHT for iou in ious)),
                str(sum(reading.doubtful for reading in of_kind)),
                str(sum(reading.doubtful and reading.iou < RIGHT for reading in of_kind)),
                f"{statistics.median(reading.seconds for reading in of_kind) * 1e3:.1f}",
            )
        )
    columns = ("alteration", "pictures", "IoU median", "least", f"below {RIGHT}", "doubtful", "both", "CPU ms, median")
    print(*Table(columns, rows, "Altered pictures", left=("alteration",), totals=1).lines(), sep="\n")


if __name__ == "__main__":
    main()

"""What the benchmarks run on: pictures of exact pairs, or an even choice from a folder."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from riot.groundtruth.pairs import exact_pair

SUFFIXES = {".png", ".gif", ".bmp", ".tif", ".tiff", ".jpg", ".jpeg", ".svg"}
PIXELS = 256
"""Side of a rendered picture."""


@dataclass(frozen=True)
class Size:
    """How much of each step is run."""

    shapes: int
    repeats: int
    """Every item is timed so often; its least time counts."""
    batch: int
    """Mean shapes of a batch; QCRS runs on pairs of batches, as in the pipeline."""
    brute_shapes: int
    """QCRS by brute force runs on all pairs of so many shapes."""
    pairs: int
    """CRS and construction run on so many pairs, those of highest QCRS."""
    overlay_pairs: int
    """CRS by polygon overlay runs on the first so many of them."""
    flow_shapes: int
    """The dataflow runs on the quick trunks of so many shapes: its tasks must not be too few."""
    workers: tuple[int, ...]
    """The dataflow runs in this process (1) and on so many processes."""


SIZES = {
    "small": Size(8, 1, 4, 4, 2, 1, 8, (1,)),
    "medium": Size(96, 3, 32, 24, 12, 3, 192, (1, 2)),
    "large": Size(240, 5, 32, 40, 40, 8, 480, (1, 2)),
}


def render(count: int, folder: Path) -> list[Path]:
    """Pictures of exact pairs, three to six pieces."""
    paths = []
    for k in range((count + 1) // 2):
        pair = exact_pair(3 + k % 4, k)
        for side, polygon in (("p", pair.p), ("q", pair.q)):
            low, high = polygon.min(axis=0), polygon.max(axis=0)
            scale = (PIXELS - 17) / (high - low).max()
            corners = (polygon - low) * [scale, -scale] + [8, 8 + scale * (high - low)[1]]
            picture = Image.new("L", (PIXELS, PIXELS), 0)
            ImageDraw.Draw(picture).polygon([tuple(corner) for corner in corners], fill=255)
            paths.append(folder / f"{k:03d}-{side}.png")
            picture.save(paths[-1])
    return paths[:count]


def pictures(root: Path, count: int | None = None) -> list[Path]:
    """``count`` pictures, evenly spaced in the sorted list of all below ``root``; all without a count."""
    every = sorted(path for path in root.rglob("*") if path.suffix.lower() in SUFFIXES)
    count = len(every) if count is None else min(count, len(every))
    chosen = np.unique(np.linspace(0, max(len(every) - 1, 0), count).astype(np.int64))
    return [every[k] for k in chosen]

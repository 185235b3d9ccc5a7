"""Steps on one shape: reading, reversibility score, quick and full trunks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from floors import Rates, necks_floor, picture_floor, trunks_floor
from inputs import Size
from measure import Timed, time_items, time_shares
from PIL import Image
from table import Row, row

from riot.geometry.shape import Shape
from riot.geometry.silhouette import read
from riot.parameters import ReversibilityParameters
from riot.scores.reversibility import concave_points, reversibility
from riot.scores.trunks import Trunks, full_trunks, quick_trunks
from riot.units import L_C

PROFILED = 12
"""So many items are run once more under a profiler."""


@dataclass(frozen=True)
class Shapes:
    """What the steps on pairs need of the shapes."""

    shapes: list[Shape]
    quick: list[Trunks]
    full: list[Trunks]


def shape_steps(paths: Sequence[Path], size: Size, rates: Rates) -> tuple[list[Row], Shapes]:
    """Rows of the steps on one shape, and the shapes with their trunks."""
    decoded = time_items(_decode, paths, size.repeats)
    ingest = time_items(read, paths, size.repeats)
    shapes = ingest.good
    points = float(np.mean([len(shape.points) for shape in shapes]))
    pixels = float(np.mean(decoded.good))
    file_bytes = float(np.mean([path.stat().st_size for path in paths]))
    rows = [
        row(
            *("ingest", "shape", ingest.ms),
            failed=len(paths) - len(shapes),
            target_ms=25.0,
            reference="decoding the file with Pillow",
            reference_ms=decoded.mean,
            floor=picture_floor(decoded.mean, pixels, file_bytes, rates),
            bounded_by=time_shares(read, paths[:PROFILED]),
            note=f"{points:.0f} points",
        )
    ]

    scores = time_items(reversibility, shapes, size.repeats)
    tolerance = ReversibilityParameters().simplify * L_C
    concave = float(np.mean([len(concave_points(shape.points, tolerance)) for shape in shapes]))
    rows.append(
        row(
            *("reversibility score", "shape", scores.ms),
            paper_ms=120.0,
            target_ms=3.0,
            reference="decoding the file with Pillow",
            reference_ms=decoded.mean,
            floor=necks_floor(concave, points, rates),
            bounded_by=time_shares(reversibility, shapes[:PROFILED]),
        )
    )

    quick, quick_row = _trunk_step("quick trunks", quick_trunks, shapes, size, rates, 15.0, None, ("S_r", scores.mean))
    about = ("quick trunks", quick.mean)
    full, full_row = _trunk_step("full trunks", full_trunks, shapes, size, rates, 60.0, 10_360.0, about)
    return [*rows, quick_row, full_row], Shapes(shapes, quick.good, full.good)


def _trunk_step(
    name: str,
    find: Callable[[Shape], Trunks],
    shapes: Sequence[Shape],
    size: Size,
    rates: Rates,
    target_ms: float,
    paper_ms: float | None,
    reference: tuple[str, float],
) -> tuple[Timed[Trunks], Row]:
    trunks = time_items(find, shapes, size.repeats)
    if len(trunks.good) < len(shapes):
        raise RuntimeError(f"{name}: a shape failed; trunks never fail on a proper shape")
    steps = row(
        *(name, "shape", trunks.ms),
        paper_ms=paper_ms,
        target_ms=target_ms,
        reference=f"{reference[0]} of the same shapes",
        reference_ms=reference[1],
        floor=trunks_floor(trunks.good, rates),
        bounded_by=time_shares(find, shapes[:PROFILED]),
    )
    return trunks, steps


def _decode(path: Path) -> int:
    """Number of pixels, all decoded; of a vector file, of its bytes, all read."""
    if path.suffix.lower() == ".svg":
        return len(path.read_bytes())
    with Image.open(path) as image:
        return int(np.asarray(image.convert("L")).size)

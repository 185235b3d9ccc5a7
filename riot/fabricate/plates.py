"""Parts laid out on the beds of a printer, upright boxes in rows. Ours."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from riot.errors import FabricationError
from riot.fabricate.shelves import shelves
from riot.fabricate.solid import Part
from riot.fabricate.tuning import BED_SPACE_MM
from riot.geometry.polyline import extent
from riot.parameters import FabricationParameters
from riot.transform.transform import Transform


@dataclass(frozen=True)
class PlacedPart:
    """One part on a plate: ``number`` counts parts of the same name; it is turned by a quarter first if ``turned``,
    then its box is moved to (x, y), its least corner, mm."""

    name: str
    number: int
    turned: bool
    x: float
    y: float


Plate = tuple[PlacedPart, ...]


def lay_out(parts: tuple[Part, ...], parameters: FabricationParameters) -> tuple[Plate, ...]:
    """Lay all parts, as many of each as are needed, on as few plates as rows allow; the deepest first.

    Raises `riot.errors.FabricationError` if a part is larger than the bed.
    """
    width, depth = parameters.bed_width_mm - 2 * BED_SPACE_MM, parameters.bed_depth_mm - 2 * BED_SPACE_MM
    boxes: list[tuple[str, int, bool, tuple[float, float]]] = []
    for part in parts:
        across, along, _ = part.size
        fits = [turned for turned in (False, True) if _fits(across, along, turned, width, depth)]
        if not fits:
            raise _too_large(part.name, across, along, parameters)
        turned = along > across if len(fits) == 2 else fits[0]
        box = (along, across) if turned else (across, along)
        boxes += [(part.name, number, turned, box) for number in range(part.count)]
    spots = shelves(np.array([box for *_, box in boxes]), width, depth, BED_SPACE_MM)
    plates: list[list[PlacedPart]] = [[] for _ in range(1 + max(spot.page for spot in spots))]
    for (name, number, turned, _), spot in zip(boxes, spots, strict=True):
        plates[spot.page].append(PlacedPart(name, number, turned, spot.x + BED_SPACE_MM, spot.y + BED_SPACE_MM))
    return tuple(tuple(plate) for plate in plates)


def check_bed(transform: Transform, parameters: FabricationParameters) -> None:
    """Raise `riot.errors.FabricationError` ``bed`` if a piece is larger than the bed even without its knuckles.

    It takes no design, so that what is certain is told at once; `lay_out` tells the rest.
    """
    side = max(extent(transform.outline_p()), extent(transform.outline_q()))
    width, depth = parameters.bed_width_mm - 2 * BED_SPACE_MM, parameters.bed_depth_mm - 2 * BED_SPACE_MM
    scale = parameters.size_mm / side
    boxes = []
    for i, piece in enumerate(transform.pieces):
        across, along = (scale * np.ptp(piece.polygon, axis=0) - parameters.gap_mm).tolist()
        if not any(_fits(across, along, turned, width, depth) for turned in (False, True)):
            boxes.append((max(across, along), i, across, along))
    if boxes:
        _, i, across, along = max(boxes)
        raise _too_large(f"piece-{i + 1}", across, along, parameters)


def _too_large(name: str, across: float, along: float, parameters: FabricationParameters) -> FabricationError:
    width, depth = parameters.bed_width_mm - 2 * BED_SPACE_MM, parameters.bed_depth_mm - 2 * BED_SPACE_MM
    share = max(min(width / across, depth / along), min(width / along, depth / across))
    return FabricationError(
        "bed",
        f"{name} is {across:.0f} × {along:.0f} mm, the bed {parameters.bed_width_mm:g} × {parameters.bed_depth_mm:g} "
        f"mm: lessen size_mm ({parameters.size_mm:g}) to about {math.floor(share * parameters.size_mm)}, or tell of a "
        "larger bed (bed_width_mm, bed_depth_mm)",
        "bed_width_mm",
    )


def _fits(across: float, along: float, turned: bool, width: float, depth: float) -> bool:
    if turned:
        across, along = along, across
    return across <= width and along <= depth

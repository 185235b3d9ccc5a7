"""Parts laid out on the beds of a printer, upright boxes in rows. Ours."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from riot.errors import FabricationError
from riot.fabricate.shelves import shelves
from riot.fabricate.solid import Part
from riot.fabricate.tuning import BED_SPACE_MM
from riot.parameters import FabricationParameters


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
            raise FabricationError(
                "bed",
                f"{part.name} is {across:.0f} × {along:.0f} mm, the bed {parameters.bed_width_mm:g} × "
                f"{parameters.bed_depth_mm:g} mm: lessen size_mm ({parameters.size_mm:g}), or tell of a "
                "larger bed (bed_width_mm, bed_depth_mm)",
                "bed_width_mm",
            )
        turned = along > across if len(fits) == 2 else fits[0]
        box = (along, across) if turned else (across, along)
        boxes += [(part.name, number, turned, box) for number in range(part.count)]
    spots = shelves(np.array([box for *_, box in boxes]), width, depth, BED_SPACE_MM)
    plates: list[list[PlacedPart]] = [[] for _ in range(1 + max(spot.page for spot in spots))]
    for (name, number, turned, _), spot in zip(boxes, spots, strict=True):
        plates[spot.page].append(PlacedPart(name, number, turned, spot.x + BED_SPACE_MM, spot.y + BED_SPACE_MM))
    return tuple(tuple(plate) for plate in plates)


def _fits(across: float, along: float, turned: bool, width: float, depth: float) -> bool:
    if turned:
        across, along = along, across
    return across <= width and along <= depth

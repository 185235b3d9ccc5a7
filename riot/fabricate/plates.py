"""Parts laid out on the beds of a printer, upright boxes in rows. Ours."""

from __future__ import annotations

from dataclasses import dataclass

from riot.fabricate.errors import FabricationError
from riot.fabricate.parameters import FabricationParameters
from riot.fabricate.solid import Part

SPACE_MM = 4.0
"""Between two parts, and along the edge of the bed."""


@dataclass(frozen=True)
class Item:
    """One part on a plate: ``number`` counts parts of the same name; it is turned by a quarter first if ``turned``,
    then its box is moved to (x, y), its least corner, mm."""

    part: str
    number: int
    turned: bool
    x: float
    y: float


Plate = tuple[Item, ...]


def lay_out(parts: tuple[Part, ...], parameters: FabricationParameters) -> tuple[Plate, ...]:
    """Lay all parts, as many of each as are needed, on as few plates as rows allow; the deepest first.

    Raises `riot.fabricate.errors.FabricationError` if a part is larger than the bed.
    """
    width, depth = parameters.bed_width_mm - SPACE_MM, parameters.bed_depth_mm - SPACE_MM
    waiting = []
    for place, part in enumerate(parts):
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
        waiting += [(-box[1], place, number, part.name, turned, box) for number in range(part.count)]
    plates: list[list[Item]] = []
    x, y, row = 0.0, 0.0, 0.0
    for _, _, number, name, turned, (across, along) in sorted(waiting, key=lambda entry: entry[:3]):
        if plates and x + across > width:
            x, y, row = SPACE_MM, y + row + SPACE_MM, 0.0
        if not plates or y + along > depth:
            plates.append([])
            x, y, row = SPACE_MM, SPACE_MM, 0.0
        plates[-1].append(Item(name, number, turned, x, y))
        x, row = x + across + SPACE_MM, max(row, along)
    return tuple(tuple(plate) for plate in plates)


def _fits(across: float, along: float, turned: bool, width: float, depth: float) -> bool:
    if turned:
        across, along = along, across
    return across + SPACE_MM <= width and along + SPACE_MM <= depth

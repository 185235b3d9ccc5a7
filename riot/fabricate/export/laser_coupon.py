"""A test piece for a laser: a comb that measures the kerf, and holes for the pin in steps of clearance. Ours.

The comb is a bar in a frame, cut into so many lamellas. Pushed together to one end of their frame they leave a space:
the kerfs of all cuts. That space divided by the number of cuts is the kerf.
"""

from __future__ import annotations

import shapely
from shapely import affinity

from riot.fabricate.export.engraving import letters
from riot.fabricate.export.flat_parts import FlatPart
from riot.parameters import FabricationParameters

CUTS = 10
"""Cuts that the space in the comb is divided by: those between lamellas and those at both ends of the frame."""

LAMELLA_MM = 6.0
COMB_MM = (12.0, 5.0)
"""Height of the lamellas, and width of the frame around them."""

CLEARANCES_MM = (0.0, 0.1, 0.2, 0.3, 0.4)
"""Added to the radius of the pin, hole by hole."""

_LETTER_MM = 2.5


def laser_coupon(parameters: FabricationParameters) -> list[FlatPart]:
    """The plate with the comb and the holes, its lines at nominal size; to be cut without compensation of the kerf.

    >>> [part.name for part in laser_coupon(FabricationParameters())]
    ['coupon']
    """
    height, frame = COMB_MM
    length = (CUTS - 1) * LAMELLA_MM
    pitch = max(length / len(CLEARANCES_MM), parameters.pin_mm + 2.0 * CLEARANCES_MM[-1] + 4.0)
    width = max(length, pitch * len(CLEARANCES_MM)) + 2.0 * frame
    base = parameters.pin_mm + 4.0 + _LETTER_MM + frame
    slot = shapely.box(frame, base, frame + length, base + height)
    lamellas = [
        shapely.LineString([(frame + k * LAMELLA_MM, base), (frame + k * LAMELLA_MM, base + height)])
        for k in range(1, CUTS - 1)
    ]
    holes, words = [], [_words(f"kerf: space / {CUTS}", 0.5 * width, base + height + 1.2)]
    for k, clearance in enumerate(CLEARANCES_MM):
        x = frame + pitch * (k + 0.5)
        holes.append(shapely.Point(x, frame + 0.5 * parameters.pin_mm).buffer(0.5 * parameters.pin_mm + clearance))
        words.append(_words(f"{clearance:.1f}", x, frame + parameters.pin_mm + 1.2))
    plate = shapely.box(0.0, 0.0, width, base + height + frame)
    region = shapely.difference(plate, shapely.union_all([slot, *holes]))
    # The cuts between lamellas go through, as the frame's do: they are lines of the layer cut, not rings.
    return [FlatPart("coupon", region, shapely.union_all(words), through=shapely.MultiLineString(lamellas))]


def _words(text: str, x: float, y: float) -> shapely.Geometry:
    region = letters(text, _LETTER_MM)
    x0, _, x1, _ = region.bounds
    return affinity.translate(region, x - 0.5 * (x0 + x1), y)

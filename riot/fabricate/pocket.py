"""A pocket for a disc magnet, on edge in the wall of a piece and open to it. Ours.

Layers have no sideways holes: a pocket is a box at each height. Its roof slopes from both sides until it closes, no
flatter than other slopes, so that it prints without supports.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import count, groupby
from typing import Literal

import numpy as np
import shapely

from riot.errors import FabricationError
from riot.fabricate.tuning import (
    GRID_MM,
    HEIGHT_DIGITS,
    HEIGHT_TOLERANCE_MM,
    LEAST_WALL_MM,
    MAGNET_FIT_MM,
    MAGNETS_MM,
    POCKET_MOUTH_MM,
    SLOPE,
    STEEPEST,
)
from riot.parameters import FabricationParameters, allowed_range
from riot.transform.pose import rotate
from riot.types import FloatArray

Side = Literal["p", "q"]
Pole = Literal["north", "south"]


@dataclass(frozen=True)
class Level:
    """How wide a pocket is along the wall between two heights; mm."""

    low: float
    high: float
    width: float


@dataclass(frozen=True)
class Pocket:
    """Room for a magnet in a piece; lengths in mm, in the piece's frame.

    Parameters
    ----------
    side : "p" or "q"
        The shape that the magnet holds shut.
    x, y : float
        Middle of the magnet's free face, nowhere before the wall.
    z : float
        Height of the magnet's middle.
    heading : float
        Which way the pocket goes into the piece, radians.
    depth : float
    levels : tuple of Level
        From the lowest up.
    pole : "north" or "south"
        The one that looks out.
    """

    side: Side
    x: float
    y: float
    z: float
    heading: float
    depth: float
    levels: tuple[Level, ...]
    pole: Pole

    def room(self, level: Level) -> shapely.Polygon:
        """What a level takes away, in plan; it begins outside the wall."""
        return self.box(-POCKET_MOUTH_MM, self.depth, level.width)

    def box(self, start: float, end: float, width: float) -> shapely.Polygon:
        """In plan, from so far inside the free face (outside if negative) to so far; on the grid."""
        box = box_at(np.array([self.x, self.y]), self.heading, (start, end), width)
        return shapely.set_precision(box, GRID_MM)


def box_at(middle: FloatArray, heading: float, reach: tuple[float, float], width: float) -> shapely.Polygon:
    """A box from ``reach[0]`` to ``reach[1]`` in a direction from a point (2,), half its width to either side; mm.

    >>> box_at(np.array([1.0, 0.0]), 0.0, (0.0, 2.0), 4.0).bounds
    (1.0, -2.0, 3.0, 2.0)
    """
    (start, end), half = reach, 0.5 * width
    corners = np.array([[start, -half], [end, -half], [end, half], [start, half]])
    return shapely.Polygon(rotate(corners, heading) + middle)


@dataclass(frozen=True)
class Bore:
    """The pocket of a magnet as it is printed, whatever its place: mm.

    ``radius`` and ``depth`` have room for the magnet, ``middle`` is the height of its axis, ``levels`` are from the
    lowest up.
    """

    radius: float
    depth: float
    middle: float
    levels: tuple[Level, ...]

    @property
    def room(self) -> tuple[float, float]:
        """Depth and width with the least walls around it."""
        return self.depth + LEAST_WALL_MM, 2.0 * (self.radius + LEAST_WALL_MM)

    def mirrored(self, height: float) -> Bore:
        """The same in a piece of this height that is printed upside down."""
        levels = [
            Level(_rounded(height - level.high), _rounded(height - level.low), level.width) for level in self.levels
        ]
        return replace(self, middle=height - self.middle, levels=tuple(reversed(levels)))


def make_bore(parameters: FabricationParameters, *, alike: bool) -> Bore:
    """The pocket of two pieces that are printed ``alike``, or one of them upside down: then it is at half the height.

    Raises `riot.errors.FabricationError` ``thin`` if no wall is left under the magnet, or over it.

    >>> bore = make_bore(FabricationParameters(magnet_mm=4.0), alike=False)
    >>> bore.middle, bore.levels[0]
    (4.5, Level(low=2.4, high=5.2, width=4.2))
    >>> bore.levels[-1].high, round(bore.levels[-1].width, 2)
    (8.2, 0.34)
    """
    bore = _bore(parameters, alike)
    if bore is not None:
        return bore
    greatest = allowed_range(FabricationParameters, "thickness_mm")[1]
    thicker = parameters
    while bore is None and thicker.height < greatest:
        thicker = replace(thicker, thickness_mm=round(thicker.height + parameters.layer_mm, 9))
        bore = _bore(thicker, alike)
    fitting = smaller_magnet(parameters, lambda smaller: _bore(smaller, alike) is not None)
    way = "" if fitting is None else f", or take smaller magnets (magnet_mm={fitting:g})"
    raise FabricationError(
        "thin",
        f"thickness_mm: pieces of {parameters.height:g} mm are too thin for a magnet of {parameters.magnet_mm:g} mm on "
        f"edge: make them {thicker.height:g} mm{way}",
        "thickness_mm",
        thicker.height,
    )


def smaller_magnet(parameters: FabricationParameters, fits: Callable[[FabricationParameters], bool]) -> float | None:
    """Diameter of the largest usual magnet, mm, that is smaller than what is asked for and fits; None if none does."""
    sizes = (size for size in reversed(MAGNETS_MM) if size < parameters.magnet_mm)
    return next((size for size in sizes if fits(replace(parameters, magnet_mm=size))), None)


def _bore(parameters: FabricationParameters, alike: bool) -> Bore | None:
    layer, height = parameters.layer_mm, parameters.height
    radius = 0.5 * parameters.magnet_mm + MAGNET_FIT_MM
    apex = radius * math.hypot(1.0, SLOPE) / SLOPE  # over the middle, where tangents of the magnet with this slope meet
    middle = 0.5 * (height - apex + radius) if alike else 0.5 * height
    foot = math.floor(round((middle - radius) / layer, HEIGHT_DIGITS))
    levels = []
    for half, same in groupby(_halves(radius, apex, middle, foot, layer), key=lambda entry: entry[1]):
        layers = [k for k, _ in same]
        levels.append(Level(_rounded(layers[0] * layer), _rounded((layers[-1] + 1) * layer), 2.0 * half))
    floor = max(LEAST_WALL_MM, parameters.inlay) - HEIGHT_TOLERANCE_MM
    if levels[0].low < floor or height - levels[-1].high < floor:
        return None
    return Bore(radius, parameters.magnet_height_mm + MAGNET_FIT_MM, middle, tuple(levels))


def _halves(radius: float, apex: float, middle: float, foot: int, layer: float) -> Iterator[tuple[int, float]]:
    """Layers from the foot up, by their numbers, and half of their widths, until the next one closes the roof."""
    for k in count(foot):
        half = min(radius, (apex - (k * layer - middle)) * SLOPE)
        yield k, half
        if half <= layer * math.tan(STEEPEST):
            return


def _rounded(height: float) -> float:
    return round(height, HEIGHT_DIGITS)

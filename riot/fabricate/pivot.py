"""Pin hinge: a knuckle on a knuckle, and a pivot that the lower one holds and whose head keeps the upper one on. Ours.

The lower knuckle is part of a piece that is printed as it lies, the upper one of a piece that is printed upside down:
so neither has anything below it that needs support. A printed pin, or a bought rod, is pressed into the lower knuckle;
a screw is held by a nut in it. The head, a cap pressed on the rod, or the screw's head sinks into the upper knuckle
on a slope, layer by layer. A hinge that is printed in place has no loose pin (`riot.fabricate.cones`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from riot.errors import FabricationError
from riot.fabricate.cones import cone_height, cone_pin, cone_radius, cone_socket
from riot.fabricate.rings import Ring, steps, taper, whole_layers
from riot.fabricate.tuning import (
    HEAD_RIM_MM,
    HEAD_STEP_MM,
    LEAST_WALL_MM,
    NUT_FLOOR_MM,
    NUT_PLAY_MM,
    SCREW_LENGTHS_MM,
    SCREWS,
    SLOPE,
    Screw,
)
from riot.parameters import FabricationParameters, allowed_range

_HEXAGON = math.cos(math.pi / 6.0)
"""Radius of the circle in a hexagon over that of the circle around it."""


@dataclass(frozen=True)
class Pivot:
    """The rings of a pin hinge around its axis; all heights over the pieces' lower face.

    ``lower`` and ``upper`` are the two knuckles, ``profile`` the pin with its head (the rod with its cap, the screw),
    ``cap`` the cap of a rod, else empty. ``length`` is that of the pin, rod or screw in mm, ``interference`` how much
    thicker it is than the hole that holds it, None where a nut does. Of a hinge that is printed in place ``lower`` is
    the socket and ``upper`` the pin in it; there is no ``profile``, and ``length`` is 0.
    """

    lower: tuple[Ring, ...]
    upper: tuple[Ring, ...]
    profile: tuple[Ring, ...]
    cap: tuple[Ring, ...]
    length: float
    interference: float | None

    @property
    def radius(self) -> float:
        """Of both knuckles, mm."""
        return self.lower[0].radius


def make_pivot(parameters: FabricationParameters) -> Pivot:
    """The pin hinge for these parameters.

    Raises `riot.errors.FabricationError` if pieces are too thin for a screw and its nut, or no such screw exists.
    """
    height, lower, radius = parameters.height, parameters.levels[0], knuckle_radius(parameters)
    if parameters.pivot == "in-place":
        if lower < cone_height(parameters):
            raise _thin(f"the socket does not hold two cones of {cone_height(parameters):g} mm", parameters)
        return Pivot(cone_socket(parameters), cone_pin(parameters), (), (), 0.0, None)
    profile, knuckle = _profile(parameters), upper_rings(parameters)
    if parameters.pivot == "screw":
        length = _screw_length(parameters)
        shaft = replace(profile[0], low=round(height - length, 9))
        return Pivot(_nut_rings(parameters, radius), knuckle, (shaft, *profile[1:]), (), length, None)
    hole = 0.5 * (parameters.pin_mm - parameters.press_mm)
    cap = tuple(replace(ring, hole=hole) for ring in profile[1:]) if parameters.pivot == "rod" else ()
    return Pivot((Ring(0.0, lower, radius, hole),), knuckle, profile, cap, height, parameters.press_mm)


def upper_rings(parameters: FabricationParameters) -> tuple[Ring, ...]:
    """The knuckle that turns, with the room for the pin's head; errors as `make_pivot`."""
    upper, radius = parameters.levels[1], knuckle_radius(parameters)
    holes = (replace(ring, low=max(ring.low, upper)) for ring in _profile(parameters))
    return tuple(Ring(ring.low, ring.high, radius, ring.radius + parameters.clearance_mm) for ring in holes)


def _profile(parameters: FabricationParameters) -> tuple[Ring, ...]:
    """The pin with its head."""
    shaft, foot = 0.5 * parameters.pin_mm, _head_foot(parameters)
    head = 0.5 * _screw(parameters).head if parameters.pivot == "screw" else shaft + HEAD_STEP_MM
    slope = taper(foot, shaft, head, parameters.layer_mm)
    if foot < parameters.levels[1]:
        raise _thin(f"the head of a pin of {parameters.pin_mm:g} mm does not fit into its knuckle", parameters)
    return (Ring(0.0, foot, shaft), *slope[:-1], replace(slope[-1], high=parameters.height))


def knuckle_radius(parameters: FabricationParameters) -> float:
    """Of a pin hinge, mm: the hole and its wall, the head and the least wall, or the nut and the least wall."""
    if parameters.pivot == "in-place":
        return cone_radius(parameters)
    hole = 0.5 * parameters.pin_mm + parameters.clearance_mm
    if parameters.pivot != "screw":
        return hole + max(parameters.wall_mm, HEAD_STEP_MM + LEAST_WALL_MM)
    screw = _screw(parameters)
    head = 0.5 * screw.head + parameters.clearance_mm
    nut = (0.5 * screw.across + NUT_PLAY_MM) / _HEXAGON
    return max(hole + parameters.wall_mm, head + LEAST_WALL_MM, nut + LEAST_WALL_MM)


def _screw(parameters: FabricationParameters) -> Screw:
    if parameters.pin_mm not in SCREWS:
        sizes = ", ".join(f"{size:g}" for size in SCREWS)
        raise FabricationError(
            "screw", f"pin_mm: there is no screw of {parameters.pin_mm:g} mm; choose one of {sizes}", "pin_mm", 3.0
        )
    return SCREWS[parameters.pin_mm]


def _screw_length(parameters: FabricationParameters) -> float:
    """The longest usual screw that does not stand out."""
    return max(length for length in SCREW_LENGTHS_MM if length <= parameters.height)


def _nut_rings(parameters: FabricationParameters, radius: float) -> tuple[Ring, ...]:
    """The lower knuckle with a pocket for the nut, open below, whose ceiling slopes to the screw's hole."""
    screw, lower, deep, slope = _screw(parameters), parameters.levels[0], _nut_depth(parameters), _nut_slope(parameters)
    if round(lower - deep, 9) < _nut_floor(parameters):
        raise _thin(f"the lower knuckle does not hold the nut of an M{parameters.pin_mm:g} screw", parameters)
    return (
        Ring(0.0, deep, radius, 0.5 * screw.across + NUT_PLAY_MM, sides=6),
        *(Ring(ring.low, ring.high, radius, ring.radius * _HEXAGON, sides=6) for ring in slope),
        Ring(slope[-1].high, lower, radius, 0.5 * parameters.pin_mm + parameters.clearance_mm),
    )


def _nut_slope(parameters: FabricationParameters) -> list[Ring]:
    """Circles around hexagons, from the pocket's to one whose corners the round hole above it just supports."""
    layer, hole = parameters.layer_mm, 0.5 * parameters.pin_mm + parameters.clearance_mm
    pocket = (0.5 * _screw(parameters).across + NUT_PLAY_MM) / _HEXAGON
    return taper(_nut_depth(parameters), pocket, hole + SLOPE * layer, layer)


def _thin(problem: str, parameters: FabricationParameters) -> FabricationError:
    """The error of pieces that are too thin, with the least thickness at which the hinge fits."""
    greatest = allowed_range(FabricationParameters, "thickness_mm")[1]
    thickness = parameters.height
    while (thickness := round(thickness + parameters.layer_mm, 9)) <= greatest:
        thicker = replace(parameters, thickness_mm=thickness)
        if _fits(thicker):
            break
    return FabricationError(
        "thin",
        f"thickness_mm: {problem} at {parameters.height:g} mm; make it {thickness:g} mm",
        "thickness_mm",
        thickness,
    )


def _fits(parameters: FabricationParameters) -> bool:
    lower, upper = parameters.levels
    if parameters.pivot == "in-place":
        return lower >= cone_height(parameters)
    if _head_foot(parameters) < upper:
        return False
    return parameters.pivot != "screw" or lower - _nut_depth(parameters) >= _nut_floor(parameters)


def _head_foot(parameters: FabricationParameters) -> float:
    """The height at which the pin begins to widen to its head, mm."""
    layer = parameters.layer_mm
    if parameters.pivot == "screw":
        width, rim = 0.5 * (_screw(parameters).head - parameters.pin_mm), layer
    else:
        width, rim = HEAD_STEP_MM, whole_layers(HEAD_RIM_MM, layer)
    return round(parameters.height - rim - (steps(width, layer) - 1) * layer, 9)


def _nut_depth(parameters: FabricationParameters) -> float:
    """How deep the nut's pocket is, mm: the nut ends where the screw does."""
    standing = parameters.height - _screw_length(parameters)
    return whole_layers(standing + _screw(parameters).nut + NUT_PLAY_MM, parameters.layer_mm)


def _nut_floor(parameters: FabricationParameters) -> float:
    """Least height of what is above the pocket, mm."""
    slope = (len(_nut_slope(parameters)) + 1) * parameters.layer_mm
    return max(whole_layers(NUT_FLOOR_MM, parameters.layer_mm), round(slope, 9))

"""Cone hinge, printed in place: a pin with a waist in a socket that follows it, closed all round. Ours.

The pin narrows to its waist and widens again, the socket as it does, so that neither comes out of the other; both lean
so little that they print as they stand, one in the other, without supports. Over the socket the pin grows to a knuckle,
and its piece grows towards it as eaves do.
"""

from __future__ import annotations

import math
from dataclasses import replace

from riot.fabricate.rings import Ring, steps, taper, whole_layers
from riot.fabricate.tuning import CONE_HOLD_MM, GRID_MM, LEAST_WALL_MM, WAIST_HEIGHT_MM
from riot.parameters import FabricationParameters


def cone_pin(parameters: FabricationParameters) -> tuple[Ring, ...]:
    """The pin from the bed up: rim, cone to the waist, cone to the upper rim; over the socket it grows to a knuckle.

    >>> pin = cone_pin(FabricationParameters(pivot="in-place"))
    >>> pin[0].radius, min(ring.radius for ring in pin), pin[-1].radius
    (2.45, 1.5, 3.6)
    """
    layer, top = parameters.layer_mm, parameters.levels[0]
    waist, wide = 0.5 * parameters.pin_mm, 0.5 * parameters.pin_mm + _step(parameters)
    slope = steps(_step(parameters), layer)
    rims = round(top / layer) - 2 * slope - _waist_layers(parameters)
    foot = round((rims + 1) // 2 * layer, 9)
    down = taper(foot, wide, waist, layer)
    middle = Ring(down[-1].high, round(down[-1].high + _waist_layers(parameters) * layer, 9), waist)
    up = taper(middle.high, waist, wide, layer)
    start = _over_socket(parameters)
    knuckle = [ring for ring in taper(start, wide, cone_radius(parameters), layer) if ring.low < parameters.height]
    rest = replace(knuckle[-1], high=parameters.height)
    return (Ring(0.0, foot, wide), *down, middle, *up[:-1], replace(up[-1], high=start), *knuckle[:-1], rest)


def eaves(parameters: FabricationParameters, room: float) -> tuple[Ring, ...]:
    """The room around the pin in its piece: of radius ``room`` (mm), then narrowing until it meets the knuckle."""
    start = _over_socket(parameters)
    narrowing = [ring for ring in taper(start, room, 0.0, parameters.layer_mm) if ring.high < parameters.height]
    knuckle = cone_pin(parameters)
    over = [ring for ring in narrowing if any(k.low <= ring.low < k.high and k.radius < ring.radius for k in knuckle)]
    return (Ring(0.0, start, room), *over)


def cone_socket(parameters: FabricationParameters) -> tuple[Ring, ...]:
    """The socket up to the lower level: so wide that no layer of the pin is nearer than the clearance, in space."""
    radius, top = cone_radius(parameters), parameters.levels[0]
    pin = [replace(ring, high=min(ring.high, top)) for ring in cone_pin(parameters) if ring.low < top]
    return tuple(
        replace(ring, radius=radius, hole=max(_room(ring, other, parameters.clearance_mm) for other in pin))
        for ring in pin
    )


def _room(ring: Ring, other: Ring, clearance: float) -> float:
    """Radius that a hole at the height of one ring needs to keep away from another, mm."""
    apart = max(0.0, other.low - ring.high, ring.low - other.high)
    if apart >= clearance:
        return 0.0
    return round(other.radius + math.sqrt(clearance**2 - apart**2) + 2.0 * GRID_MM, 9)  # both discs are rounded


def cone_radius(parameters: FabricationParameters) -> float:
    """Of the socket, mm: the wall is at the waist, and the least wall at the mouths."""
    hole = 0.5 * parameters.pin_mm + parameters.clearance_mm
    return hole + max(parameters.wall_mm, _step(parameters) + LEAST_WALL_MM)


def _over_socket(parameters: FabricationParameters) -> float:
    """Height from which something may lie over the socket, mm."""
    lower, upper = parameters.levels
    return max(upper, round(lower + whole_layers(parameters.clearance_mm, parameters.layer_mm), 9))


def cone_height(parameters: FabricationParameters) -> float:
    """Least height of the socket, mm: two cones, the waist, and a layer of rim on the bed."""
    layers = 2 * steps(_step(parameters), parameters.layer_mm) + _waist_layers(parameters) + 1
    return round(layers * parameters.layer_mm, 9)


def _step(parameters: FabricationParameters) -> float:
    """How much wider the rims are than the waist, mm in radius."""
    return parameters.clearance_mm + CONE_HOLD_MM


def _waist_layers(parameters: FabricationParameters) -> int:
    return round(whole_layers(WAIST_HEIGHT_MM, parameters.layer_mm) / parameters.layer_mm)

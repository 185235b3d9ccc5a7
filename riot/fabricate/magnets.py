"""Where magnets go: in the walls of the two free ends of the chain, one pair for either closed shape. Ours.

The open hinge closes on one wall as P and on another as Q. Each wall takes a pocket in either piece, face to face, as
near to the hinge as the wall is straight enough and both pieces are large enough. Every magnet meets one other only: so
all of the one piece show their north poles, all of the other their south poles, and what meets attracts.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from riot.errors import FabricationError
from riot.fabricate.model import HingeEnd, printed_upside_down
from riot.fabricate.outlines import disc
from riot.fabricate.pocket import Bore, Pocket, Side, box_at, make_bore, smaller_magnet
from riot.fabricate.tuning import (
    GRID_MM,
    HEIGHT_DIGITS,
    MAGNET_RECESS_MM,
    MAGNET_STEP_MM,
    OUTLINE_SPARE_MM,
    POCKET_MOUTH_MM,
    SAME_WALL_MM,
)
from riot.parameters import FabricationParameters
from riot.transform.pose import Pose, direction, rotate
from riot.transform.transform import Transform
from riot.types import FloatArray

Ends = tuple[HingeEnd, HingeEnd]
_Seat = tuple[Pocket, Pocket]
"""Face to face, in the piece before the hinge and in that after it."""

_SHUT: dict[Side, tuple[float, str]] = {"p": (0.0, "first"), "q": (1.0, "second")}
"""For either side: the time when it is closed, and which shape it is."""


@dataclass(frozen=True, eq=False)
class _Shut:
    """The piece before the open hinge and that after it, closed: mm, in the frame of the shape.

    ``pieces`` are their numbers, ``upside_down`` whether they print so, ``solids`` what is solid of them outside the
    room of hinges, ``walls`` the lines along which they meet, ``corner`` the hinge.
    """

    side: Side
    pose: Pose
    scale: float
    pieces: tuple[int, int]
    upside_down: tuple[bool, bool]
    solids: tuple[shapely.Geometry, shapely.Geometry]
    walls: tuple[shapely.LineString, ...]

    @property
    def corner(self) -> FloatArray:
        """(2,) the hinge."""
        point: FloatArray = self.scale * self.pose.origins[self.pieces[1]]
        return point

    def in_piece(self, k: int, point: FloatArray, heading: float) -> tuple[float, float, float]:
        """A point (2,) and a direction in the frame of one of the pieces."""
        turn = float(self.pose.headings[self.pieces[k]])
        ((x, y),) = rotate((point - self.scale * self.pose.origins[self.pieces[k]])[None], -turn).tolist()
        return x, y, heading - turn


def magnet_pockets(
    bodies: Sequence[shapely.Polygon],
    ends: Sequence[Ends],
    transform: Transform,
    hinge: int,
    parameters: FabricationParameters,
    scale: float,
) -> dict[int, tuple[Pocket, ...]]:
    """The pockets, for P and for Q, of the piece before the open hinge and of that after it, by their numbers.

    Raises `riot.errors.FabricationError` ``thin`` if pieces are too thin for the magnet, ``magnet`` if it fits nowhere.
    """
    both = {side: _shut(side, bodies, ends, transform, hinge, scale) for side in _SHUT}
    best = _best(both, parameters)
    if isinstance(best, str):
        raise _refusal(best, both, parameters)
    p, q = best
    return {piece: (p[k], q[k]) for k, piece in enumerate(both["p"].pieces)}


def _best(both: Mapping[Side, _Shut], parameters: FabricationParameters) -> tuple[_Seat, _Seat] | str:
    """Seats for P and for Q, near to the hinge and with walls between them, or what is in the way."""
    first, second = both["p"].upside_down
    bore = make_bore(parameters, alike=first == second)
    for side, shut in both.items():
        if next(_seats(shut, bore, parameters), None) is None:
            before, after = (f"piece-{piece + 1}" for piece in shut.pieces)
            return f"{before} and {after} meet along no wall of the {_SHUT[side][1]} shape that is straight and thick"
    seats_q: Iterable[_Seat] = _seats(both["q"], bore, parameters)
    for p in _seats(both["p"], bore, parameters):
        seen = []
        for q in seats_q:
            if _apart(p, q, bore):
                return p, q
            seen.append(q)
        seats_q = seen
    return "those of both shapes come too near to each other"


def _shut(
    side: Side,
    bodies: Sequence[shapely.Polygon],
    ends: Sequence[Ends],
    transform: Transform,
    hinge: int,
    scale: float,
) -> _Shut:
    pose, pieces = transform.pose(_SHUT[side][0]), ((hinge - 1) % len(transform), hinge)
    solids, outlines = [], []
    for piece in pieces:
        rooms = [disc(end.x, end.y, end.relief_radius, outside=True) for end in ends[piece] if end.rings]
        left = shapely.difference(bodies[piece], shapely.union_all(rooms))
        solids.append(shapely.transform(left, lambda points, i=piece: scale * pose.place(i, points / scale)))
        outlines.append(scale * pose.place(piece, transform.pieces[piece].polygon))
    near = shapely.Polygon(outlines[1]).exterior.buffer(SAME_WALL_MM)
    shared = shapely.line_merge(shapely.intersection(shapely.LinearRing(outlines[0]), near))
    walls = tuple(line for line in shapely.get_parts(shared) if line.geom_type == "LineString")
    upside_down = printed_upside_down(ends[pieces[0]]), printed_upside_down(ends[pieces[1]])
    return _Shut(side, pose, scale, pieces, upside_down, (solids[0], solids[1]), walls)


def _seats(shut: _Shut, bore: Bore, parameters: FabricationParameters) -> Iterator[_Seat]:
    """The places along the walls, in steps, where magnets fit into both pieces, the nearest to the hinge first."""
    depth, width = bore.room
    for solid in shut.solids:
        shapely.prepare(solid)
    for middle, along in sorted(
        _places(shut.walls, width), key=lambda place: float(np.hypot(*(place[0] - shut.corner)))
    ):
        across = along + 0.5 * math.pi
        if not shut.solids[0].contains(shapely.Point(middle + 0.5 * depth * direction(across))):
            across += math.pi
        first = _pocket(shut, 0, middle, across, bore, parameters)
        second = None if first is None else _pocket(shut, 1, middle, across + math.pi, bore, parameters)
        if first is not None and second is not None:
            yield first, second


def _places(walls: Sequence[shapely.LineString], width: float) -> Iterator[tuple[FloatArray, float]]:
    """(2,) middles of chords of walls, as long as a width, and the chords' directions, radians."""
    for wall in walls:
        for start in np.arange(0.0, wall.length - width, MAGNET_STEP_MM).tolist():
            first, last = (shapely.get_coordinates(wall.interpolate(start + step))[0] for step in (0.0, width))
            yield 0.5 * (first + last), math.atan2(last[1] - first[1], last[0] - first[0])


def _pocket(
    shut: _Shut, k: int, middle: FloatArray, heading: float, bore: Bore, parameters: FabricationParameters
) -> Pocket | None:
    """The pocket of one of the pieces in the middle of a chord of the wall, or None if it does not fit there.

    Its face is where the piece is solid all along the chord.
    """
    depth, width = bore.room
    limit = 0.5 * parameters.gap_mm + OUTLINE_SPARE_MM + MAGNET_RECESS_MM
    if not shut.solids[k].covers(box_at(middle, heading, (limit, depth), width)):
        return None
    strip, inwards = box_at(middle, heading, (-POCKET_MOUTH_MM, limit), width), direction(heading)
    outside = (shapely.get_coordinates(strip.difference(shut.solids[k])) - middle) @ inwards
    face = round(float(outside.max(initial=0.0)), HEIGHT_DIGITS)
    if not shut.solids[k].covers(box_at(middle, heading, (face + GRID_MM, face + depth), width)):
        return None
    if shut.upside_down[k]:
        bore = bore.mirrored(parameters.height)
    x, y, turn = shut.in_piece(k, middle + face * inwards, heading)
    return Pocket(shut.side, x, y, bore.middle, turn, bore.depth, bore.levels, ("north", "south")[k])


def _apart(first: _Seat, second: _Seat, bore: Bore) -> bool:
    """Whether there is a wall between two pockets of either piece."""
    depth, width = bore.room
    return not any(
        one.box(0.0, depth, width).intersects(other.box(0.0, bore.depth, 2.0 * bore.radius))
        for pair in zip(first, second, strict=True)
        for one, other in (pair, pair[::-1])
    )


def _refusal(problem: str, both: Mapping[Side, _Shut], parameters: FabricationParameters) -> FabricationError:
    """Of magnets for which there is no place; tells of smaller ones for which there is."""
    fitting = smaller_magnet(parameters, lambda smaller: not isinstance(_best(both, smaller), str))
    way = "" if fitting is None else f"take smaller ones (magnet_mm={fitting:g}), "
    return FabricationError(
        "magnet",
        f"magnet_mm: no place for magnets of {parameters.magnet_mm:g} × {parameters.magnet_height_mm:g} mm at the open "
        f"hinge: {problem}: {way}enlarge size_mm ({parameters.size_mm:g}), or leave them out",
        "size_mm",
    )

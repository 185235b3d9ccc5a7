"""Find pins on the swung arcs of a dissection, and solve its tree so that it meets them (theory §8). Ours."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely

from riot.construction.detail import Pull, add_detail
from riot.construction.dissection import Dissection
from riot.construction.pins import Pin
from riot.construction.tree_match import TreeMatch, match_tree
from riot.construction.tuning import (
    KEPT_POINT_REACH,
    LEAF_RADIUS,
    PIN_CHECKS,
    PIN_POSITION_SLACK,
    PIN_REACH,
    PIN_TOLERANCE,
    PIN_WEIGHT,
)
from riot.errors import ConstructionError
from riot.kernels.matching import along, at
from riot.types import FloatArray
from riot.units import L_C


@dataclass(frozen=True, eq=False)
class PinnedSection:
    """A pinned section of the swung arc of ``cell``, from position ``start`` to ``stop`` along it."""

    cell: int
    start: float
    stop: float


def pinned_paths(dissection: Dissection, outer: FloatArray, pins: Sequence[Pin], name: str) -> list[FloatArray]:
    """The `Dissection.paths` that meet the pins to `riot.construction.tuning.PIN_TOLERANCE`.

    ``outer`` (n, 2) is the other trunk, around which the pieces lie in the frame of the pins, edge k for cell k;
    ``name`` is the shape's, for messages. Raises ConstructionError ``pins`` if a pin is not on the outline or cannot be
    met.
    """
    if not pins:
        return dissection.paths
    arcs, sections = list(dissection.arcs), dict[int, list[PinnedSection]]()
    # Drawn lines first: they change the arcs of which others are kept.
    for k, pin in sorted(enumerate(pins), key=lambda item: not item[1].drawn):
        label = f"pin {k} of {name}"
        outline = _PlacedOutline(dissection, outer, arcs)
        if pin.drawn:
            arc, section = _drawn(outline, pin, label)
            arcs[section.cell] = arc
            sections[k] = [section]
        else:
            sections[k] = _kept(outline, pin, label)
    drawn_on = {sections[k][0].cell for k, pin in enumerate(pins) if pin.drawn}
    if len(drawn_on) < sum(pin.drawn for pin in pins):
        raise ConstructionError("pins", f"two lines are drawn on one piece of {name}: join them into one")
    match = match_tree(dissection.tree, arcs, dissection.detail) if drawn_on else dissection.match
    pull = _pull(match, [section for of_pin in sections.values() for section in of_pin])
    paths = add_detail(dissection.plain_paths, arcs, match, dissection.detail, pull).paths
    for k, of_pin in sorted(sections.items()):
        for section in of_pin:
            distance = _missed(arcs[section.cell], paths[section.cell], section)
            if distance > PIN_TOLERANCE:
                raise ConstructionError(
                    "pins",
                    f"pin {k} of {name} cannot be met (missed by {distance:.2g}, allowed {PIN_TOLERANCE:.2g}): another "
                    "is across the same cut, or the cut would cross another or leave the trunk; move it, or pin less",
                )
    return paths


class _PlacedOutline:
    """The swung arcs carried out to where their pieces lie around the other trunk: the outline, in the pins' frame."""

    def __init__(self, dissection: Dissection, outer: FloatArray, arcs: Sequence[FloatArray]) -> None:
        """Carry every arc by the rigid motion of its trunk edge."""
        n = len(outer)
        self.trunk, self.inner_arcs = dissection.trunk, arcs
        self.edges = [(self.trunk[[k, (k + 1) % n]], outer[[k, (k + 1) % n]]) for k in range(n)]
        self.arcs = [_carried(arc, *edge) for arc, edge in zip(arcs, self.edges, strict=True)]
        self.lengths = [along(arc) for arc in arcs]
        self.starts = np.concatenate([[0.0], np.cumsum([lengths[-1] for lengths in self.lengths])])

    def position(self, point: FloatArray, label: str) -> float:
        """Where around the outline the boundary point nearest to ``point`` is; ConstructionError if none is near."""
        target = shapely.Point(point)
        lines = [shapely.LineString(arc) for arc in self.arcs]
        distances = shapely.distance(lines, target)
        cell = int(np.argmin(distances))
        if not distances[cell] <= PIN_REACH:
            raise ConstructionError(
                "pins",
                f"{label}: ({point[0]:.4g}, {point[1]:.4g}) lies {distances[cell]:.3g} from the outline, more than "
                f"{PIN_REACH:.3g}: give a point on it (in Python, Shape.from_source converts to the shape's "
                "frame)",
            )
        return float(self.starts[cell] + shapely.line_locate_point(lines[cell], target))

    def shorter_way(self, positions: Sequence[float]) -> tuple[float, float, bool]:
        """Start and stop, forwards, of the shorter way through ``positions``, and whether they are in that order."""
        total = float(self.starts[-1])
        ahead = [(after - before) % total for before, after in pairwise(positions)]
        back = [(total - step) % total for step in ahead]
        if sum(ahead) <= sum(back):
            return positions[0], positions[0] + sum(ahead), True
        return positions[-1], positions[-1] + sum(back), False

    def split(self, start: float, stop: float) -> list[PinnedSection]:
        """The section of every arc that lies between two positions around the outline."""
        total = float(self.starts[-1])
        sections = []
        for turn in (-1, 0, 1):
            for cell, lengths in enumerate(self.lengths):
                first = float(self.starts[cell]) + turn * total
                low, high = max(start - first, 0.0), min(stop - first, float(lengths[-1]))
                if high > low:
                    sections.append(PinnedSection(cell, low, high))
        return sections


def _carried(points: FloatArray, source: FloatArray, target: FloatArray) -> FloatArray:
    """(k, 2) points moved by the rigid motion that brings one segment (2, 2) onto another as long."""
    turn = complex(*(target[1] - target[0])) / complex(*(source[1] - source[0]))
    turn /= abs(turn)
    moved = (points - source[0]) @ np.array([[turn.real, turn.imag], [-turn.imag, turn.real]]) + target[0]
    return np.asarray(moved)


def _kept(outline: _PlacedOutline, pin: Pin, label: str) -> list[PinnedSection]:
    """The sections of the boundary that a pin keeps."""
    positions = [outline.position(point, label) for point in pin.points]
    if len(positions) == 1:
        return outline.split(positions[0] - KEPT_POINT_REACH, positions[0] + KEPT_POINT_REACH)
    start, stop, _ = outline.shorter_way(positions)
    return outline.split(start, stop)


def _drawn(outline: _PlacedOutline, pin: Pin, label: str) -> tuple[FloatArray, PinnedSection]:
    """The swung arc with the drawn line in it, and where on it that is."""
    ends = [outline.position(pin.points[k], label) for k in (0, -1)]
    start, stop, forwards = outline.shorter_way(ends)
    sections = outline.split(start, stop)
    if len(sections) != 1:
        raise ConstructionError(
            "pins",
            f"{label}: a drawn line lies on one piece, and a hinge is between its ends: draw it in two parts",
        )
    cell, low, high = sections[0].cell, sections[0].start, sections[0].stop
    inner, outer = outline.edges[cell]
    line = _carried(pin.points if forwards else pin.points[::-1], outer, inner)
    if not shapely.covers(shapely.Polygon(outline.trunk), shapely.LineString(line)):
        raise ConstructionError(
            "pins", f"{label}: the drawn line leaves the trunk that its piece swings into: keep nearer to the outline"
        )
    arc, lengths = outline.inner_arcs[cell], outline.lengths[cell]
    arc = np.concatenate([arc[lengths < low - PIN_POSITION_SLACK], line, arc[lengths > high + PIN_POSITION_SLACK]])
    if not shapely.is_simple(shapely.LineString(arc)):
        raise ConstructionError(
            "pins", f"{label}: the drawn line crosses the outline of its piece: draw it clear of it"
        )
    first = int((lengths < low - PIN_POSITION_SLACK).sum())
    measured = along(arc)
    return arc, PinnedSection(cell, float(measured[first]), float(measured[first + len(line) - 1]))


def _pull(match: TreeMatch, sections: Sequence[PinnedSection]) -> Pull:
    """Draw the samples of pinned sections to their own arc; between two pins that face each other, to the middle."""
    total = np.zeros_like(match.targets)
    count = np.zeros(len(match.targets))
    for section in sections:
        for k, arc in enumerate(match.tree):
            if section.cell not in arc.sides:
                continue
            side = arc.sides.index(section.cell)
            rows = np.arange(match.offsets[k], match.offsets[k + 1])
            positions = match.positions[side, rows]
            rows = rows[
                (positions >= section.start - PIN_POSITION_SLACK) & (positions <= section.stop + PIN_POSITION_SLACK)
            ]
            total[rows] += match.sides[side, rows]
            count[rows] += 1.0
    wanted = np.divide(total, count[:, None], out=match.targets.copy(), where=count[:, None] > 0.0)
    return Pull(wanted, np.where(count > 0.0, PIN_WEIGHT, 0.0))


def _missed(arc: FloatArray, path: FloatArray, section: PinnedSection) -> float:
    """Greatest distance from a pinned section to the path, `LEAF_RADIUS` off the hinges."""
    lengths = along(arc)
    inside = lengths[(lengths > section.start) & (lengths < section.stop)]
    even = np.linspace(section.start, section.stop, PIN_CHECKS)
    points = at(arc, lengths, np.sort(np.concatenate([even, inside])))
    near = np.minimum(np.hypot(*(points - arc[0]).T), np.hypot(*(points - arc[-1]).T)) < LEAF_RADIUS * L_C
    line = shapely.LineString(path)
    return float(shapely.distance(shapely.points(points[~near]), line).max(initial=0.0))

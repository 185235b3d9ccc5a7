"""Find pins on the swung arcs of a dissection, and solve its tree so that it meets them (theory §8). Ours."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely

from riot.construction.detail import Pull, add_detail
from riot.construction.dissection import Dissection
from riot.construction.pins import Pin
from riot.construction.placed_outline import PinnedSection, PlacedOutline, carried
from riot.construction.tree_match import TreeMatch, match_tree
from riot.construction.tuning import (
    KEPT_POINT_REACH,
    LEAF_RADIUS,
    PIN_POSITION_SLACK,
    PIN_TOLERANCE,
    PIN_WEIGHT,
    SECTION_SLACK,
)
from riot.errors import PinError
from riot.kernels.matching import along, at
from riot.types import FloatArray
from riot.units import L_C


def pinned_paths(dissection: Dissection, outer: FloatArray, pins: Sequence[Pin], name: str) -> list[FloatArray]:
    """The `Dissection.paths` that meet the pins to `riot.construction.tuning.PIN_TOLERANCE`.

    ``outer`` (n, 2) is the other trunk, around which the pieces lie in the frame of the pins, edge k for cell k;
    ``name`` is the shape's, for messages. Raises `riot.errors.PinError` if a pin is not on the outline or cannot be
    met.
    """
    numbered = list(enumerate(pins))
    kept = [(k, pin) for k, pin in numbered if not pin.drawn]
    paths = _solved_paths(dissection, outer, kept, name) if kept else dissection.paths
    if len(kept) == len(pins):
        return paths
    # Where nothing is drawn the outline stays what it is now, not what the input's is: an edit is local.
    return _solved_paths(replace(dissection, arcs=tuple(paths)), outer, numbered, name)


def _solved_paths(
    dissection: Dissection, outer: FloatArray, pins: Sequence[tuple[int, Pin]], name: str
) -> list[FloatArray]:
    """As `pinned_paths`, of numbered pins, with the dissection's arcs where nothing is drawn."""
    arcs, sections = list(dissection.arcs), dict[int, list[PinnedSection]]()
    # Drawn lines first: they change the arcs of which others are kept.
    for k, pin in sorted(pins, key=lambda item: not item[1].drawn):
        label = f"pin {k} of {name}"
        outline = PlacedOutline(dissection, outer, arcs)
        try:
            if pin.drawn:
                arc, section = drawn_section(outline, pin, label)
                if any(section.cell == of[0].cell for of in sections.values()):
                    raise PinError(f"two lines are drawn on one piece of {name}: join them into one")
                arcs[section.cell] = arc
                sections[k] = [section]
            else:
                sections[k] = kept_sections(outline, pin, label)
        except PinError as error:
            raise error.of(k, pin.points) from None
    drawn = any(pin.drawn for _, pin in pins)
    match = match_tree(dissection.tree, arcs, dissection.detail) if drawn else dissection.match
    pull = _pull(match, [section for of_pin in sections.values() for section in of_pin])
    paths = add_detail(dissection.plain_paths, arcs, match, dissection.detail, pull).paths
    outline = PlacedOutline(dissection, outer, arcs)
    for k, _ in pins:
        missed = [_missed(outline, paths[section.cell], section) for section in sections[k]]
        distance = max((far for far, _ in missed), default=0.0)
        if distance > PIN_TOLERANCE:
            raise PinError(
                f"pin {k} of {name} cannot be met (missed by {distance:.2g}, allowed {PIN_TOLERANCE:.2g}): another "
                "is across the same cut, or the cut would cross another or leave the trunk; move it, or pin less",
                k,
            ).at(np.concatenate([points for _, points in missed]))
    return paths


def kept_sections(outline: PlacedOutline, pin: Pin, label: str) -> list[PinnedSection]:
    """The sections of the boundary that a pin keeps."""
    positions = [outline.position(point, label) for point in pin.points]
    start, stop, _ = outline.shorter_way(positions)
    if start == stop:
        return outline.split(start - KEPT_POINT_REACH, stop + KEPT_POINT_REACH)
    return outline.split(start, stop)


def drawn_section(outline: PlacedOutline, pin: Pin, label: str) -> tuple[FloatArray, PinnedSection]:
    """The swung arc with the drawn line in it, and where on it that is."""
    ends = [outline.position(pin.points[k], label) for k in (0, -1)]
    start, stop, forwards = outline.shorter_way(ends)
    sections = outline.split(start, stop)
    if len(sections) != 1:
        raise PinError(
            f"{label}: a drawn line lies on one piece, and a hinge is between its ends: draw it in two parts"
        )
    cell, low, high = sections[0].cell, sections[0].start, sections[0].stop
    inner, outer = outline.edges[cell]
    line = carried(pin.points if forwards else pin.points[::-1], outer, inner)
    # A piece may reach the edge of the trunk, and be carried there up to a rounding.
    trunk = shapely.Polygon(outline.trunk).buffer(PIN_POSITION_SLACK)
    if not shapely.covers(trunk, shapely.LineString(line)):
        outside = line[~shapely.covers(trunk, shapely.points(line))]
        raise PinError(
            f"{label}: the drawn line leaves the trunk that its piece swings into: keep nearer to the outline"
        ).at(carried(outside, inner, outer))
    arc, lengths = outline.inner_arcs[cell], outline.lengths[cell]
    head, tail = arc[lengths < low - SECTION_SLACK], arc[lengths > high + SECTION_SLACK]
    # A line that ends at a hinge does so to the last bit.
    line[0], line[-1] = (arc[0] if len(head) == 0 else line[0]), (arc[-1] if len(tail) == 0 else line[-1])
    arc = np.concatenate([head, line, tail])
    if not shapely.is_simple(shapely.LineString(arc)):
        raise PinError(f"{label}: the drawn line crosses the outline of its piece: draw it clear of it")
    measured = along(arc)
    return arc, PinnedSection(cell, float(measured[len(head)]), float(measured[len(head) + len(line) - 1]))


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
            # A section ends between samples: lines between them that are partly in it lead where it does.
            low, high = np.minimum(positions[:-1], positions[1:]), np.maximum(positions[:-1], positions[1:])
            lines = (high > section.start + PIN_POSITION_SLACK) & (low < section.stop - PIN_POSITION_SLACK)
            rows = rows[np.append(lines, False) | np.append(False, lines)]
            total[rows] += match.sides[side, rows]
            count[rows] += 1.0
    wanted = np.divide(total, count[:, None], out=match.targets.copy(), where=count[:, None] > 0.0)
    return Pull(wanted, np.where(count > 0.0, PIN_WEIGHT, 0.0))


def _missed(outline: PlacedOutline, path: FloatArray, section: PinnedSection) -> tuple[float, FloatArray]:
    """Greatest distance from a pinned section to the path, `LEAF_RADIUS` off the hinges, and where (k, 2) on the
    outline it is more than allowed."""
    arc, placed = outline.inner_arcs[section.cell], outline.arcs[section.cell]
    positions = outline.checks(section)
    points = at(arc, outline.lengths[section.cell], positions)
    near = np.minimum(np.hypot(*(points - arc[0]).T), np.hypot(*(points - arc[-1]).T)) < LEAF_RADIUS * L_C
    far = np.where(near, 0.0, shapely.distance(shapely.points(points), shapely.LineString(path)))
    return float(far.max()), at(placed, outline.lengths[section.cell], positions[far > PIN_TOLERANCE])

"""Pins on a dissection: where they are on its swung arcs, and the tree solved with them (theory §8). Ours."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely

from riot.construction.detail import Pull, add_detail
from riot.construction.dissection import Dissection
from riot.construction.pins import Pin
from riot.construction.tree_match import LEAF, TreeMatch, match_tree
from riot.errors import ConstructionError
from riot.kernels.matching import along, at
from riot.types import FloatArray
from riot.units import D_C, L_C

TOLERANCE = 1e-4 * L_C
"""A pinned stretch is met to this distance, but within `LEAF` of a hinge, which the outline meets straight."""

NEAR = 0.05 * D_C
"""Pins may lie this far from the outline."""

AROUND = L_C / 100
"""A kept point stands for this much of the boundary on either side of it."""

WEIGHT = 1e14
"""Of a pinned sample: more than any stiffness of the system, by enough to meet `TOLERANCE`."""


@dataclass(frozen=True, eq=False)
class PinnedInterval:
    """A pinned stretch of the swung arc of ``cell``, from position ``start`` to ``stop`` along it."""

    cell: int
    start: float
    stop: float


def pinned_paths(dissection: Dissection, outer: FloatArray, pins: Sequence[Pin], name: str) -> list[FloatArray]:
    """The `Dissection.paths` with the pins met to `TOLERANCE`.

    ``outer`` (n, 2) is the other trunk, which the pieces lie around in the frame of the pins, edge k for cell k;
    ``name`` is the shape's, for messages. ConstructionError ``pins`` if a pin is not on the outline or cannot be met.
    """
    if not pins:
        return dissection.paths
    arcs, stretches = list(dissection.arcs), dict[int, list[PinnedInterval]]()
    # Drawn lines first: they change what is kept.
    for k, pin in sorted(enumerate(pins), key=lambda item: not item[1].drawn):
        said = f"pin {k} of {name}"
        placed = _Placed(dissection, outer, arcs)
        if pin.drawn:
            arc, stretch = _drawn(placed, pin, said)
            arcs[stretch.cell] = arc
            stretches[k] = [stretch]
        else:
            stretches[k] = _kept(placed, pin, said)
    drawn_on = {stretches[k][0].cell for k, pin in enumerate(pins) if pin.drawn}
    if len(drawn_on) < sum(pin.drawn for pin in pins):
        raise ConstructionError("pins", f"two lines are drawn on one piece of {name}: join them into one")
    match = match_tree(dissection.tree, arcs, dissection.detail) if drawn_on else dissection.match
    pull = _pull(match, [stretch for some in stretches.values() for stretch in some])
    paths = add_detail(dissection.plain_paths, arcs, match, dissection.detail, pull).paths
    for k, some in sorted(stretches.items()):
        for stretch in some:
            far = _missed(arcs[stretch.cell], paths[stretch.cell], stretch)
            if far > TOLERANCE:
                raise ConstructionError(
                    "pins",
                    f"pin {k} of {name} cannot be met (missed by {far:.2g}, allowed {TOLERANCE:.2g}): another is "
                    "across the same cut, or the cut would cross another or leave the trunk; move it, or pin less",
                )
    return paths


class _Placed:
    """The swung arcs carried out to where their pieces lie around the other trunk: the outline, in the pins' frame."""

    def __init__(self, dissection: Dissection, outer: FloatArray, arcs: Sequence[FloatArray]) -> None:
        """Carry every arc by the rigid motion of its trunk edge."""
        n = len(outer)
        inner = dissection.trunk
        self.trunk, self.inner_arcs = inner, arcs
        edges = [(inner[[k, (k + 1) % n]], outer[[k, (k + 1) % n]]) for k in range(n)]
        self.edges = edges
        self.arcs = [_carried(arc, *edge) for arc, edge in zip(arcs, edges, strict=True)]
        self.lengths = [along(arc) for arc in arcs]
        self.starts = np.concatenate([[0.0], np.cumsum([lengths[-1] for lengths in self.lengths])])

    def position(self, point: FloatArray, said: str) -> float:
        """Where around the outline the boundary point nearest to ``point`` is; ConstructionError if none is near."""
        where = shapely.Point(point)
        lines = [shapely.LineString(arc) for arc in self.arcs]
        distances = shapely.distance(lines, where)
        cell = int(np.argmin(distances))
        if not distances[cell] <= NEAR:
            raise ConstructionError(
                "pins",
                f"{said}: ({point[0]:.4g}, {point[1]:.4g}) lies {distances[cell]:.3g} from the outline, more than "
                f"{NEAR:.3g}: give a point on it in the shape's frame (Shape.from_source converts)",
            )
        return float(self.starts[cell] + shapely.line_locate_point(lines[cell], where))

    def stretch(self, positions: Sequence[float]) -> tuple[float, float, bool]:
        """From where to where, forwards, the stretch through ``positions`` runs, and whether they are in that order."""
        total = float(self.starts[-1])
        ahead = [(after - before) % total for before, after in pairwise(positions)]
        back = [(total - step) % total for step in ahead]
        if sum(ahead) <= sum(back):
            return positions[0], positions[0] + sum(ahead), True
        return positions[-1], positions[-1] + sum(back), False

    def split(self, start: float, stop: float) -> list[PinnedInterval]:
        """The arcs' parts of a stretch around the outline."""
        total = float(self.starts[-1])
        found = []
        for turn in (-1, 0, 1):
            for cell, lengths in enumerate(self.lengths):
                first = float(self.starts[cell]) + turn * total
                low, high = max(start - first, 0.0), min(stop - first, float(lengths[-1]))
                if high > low:
                    found.append(PinnedInterval(cell, low, high))
        return found


def _carried(points: FloatArray, source: FloatArray, target: FloatArray) -> FloatArray:
    """(k, 2) points moved by the rigid motion that brings one segment (2, 2) onto another as long."""
    turn = complex(*(target[1] - target[0])) / complex(*(source[1] - source[0]))
    turn /= abs(turn)
    moved = (points - source[0]) @ np.array([[turn.real, turn.imag], [-turn.imag, turn.real]]) + target[0]
    return np.asarray(moved)


def _kept(placed: _Placed, pin: Pin, said: str) -> list[PinnedInterval]:
    positions = [placed.position(point, said) for point in pin.points]
    if len(positions) == 1:
        return placed.split(positions[0] - AROUND, positions[0] + AROUND)
    start, stop, _ = placed.stretch(positions)
    return placed.split(start, stop)


def _drawn(placed: _Placed, pin: Pin, said: str) -> tuple[FloatArray, PinnedInterval]:
    """The swung arc with the drawn line in it, and where on it that is."""
    ends = [placed.position(pin.points[k], said) for k in (0, -1)]
    start, stop, forwards = placed.stretch(ends)
    parts = placed.split(start, stop)
    if len(parts) != 1:
        raise ConstructionError(
            "pins",
            f"{said}: a drawn line lies on one piece, and a hinge is between its ends: draw it in two parts",
        )
    cell, low, high = parts[0].cell, parts[0].start, parts[0].stop
    inner, outer = placed.edges[cell]
    line = _carried(pin.points if forwards else pin.points[::-1], outer, inner)
    if not shapely.covers(shapely.Polygon(placed.trunk), shapely.LineString(line)):
        raise ConstructionError(
            "pins", f"{said}: the drawn line leaves the trunk that its piece swings into: keep nearer to the outline"
        )
    arc, lengths = placed.inner_arcs[cell], placed.lengths[cell]
    arc = np.concatenate([arc[lengths < low - 1e-9], line, arc[lengths > high + 1e-9]])
    if not shapely.is_simple(shapely.LineString(arc)):
        raise ConstructionError("pins", f"{said}: the drawn line crosses the outline of its piece: draw it clear of it")
    first = int((lengths < low - 1e-9).sum())
    measured = along(arc)
    return arc, PinnedInterval(cell, float(measured[first]), float(measured[first + len(line) - 1]))


def _pull(match: TreeMatch, stretches: Sequence[PinnedInterval]) -> Pull:
    """Draw the samples of pinned stretches to their own arc; between two pins that face each other, to the middle."""
    total = np.zeros_like(match.targets)
    count = np.zeros(len(match.targets))
    for stretch in stretches:
        for k, arc in enumerate(match.tree):
            if stretch.cell not in arc.sides:
                continue
            side = arc.sides.index(stretch.cell)
            rows = np.arange(match.offsets[k], match.offsets[k + 1])
            positions = match.positions[side, rows]
            rows = rows[(positions >= stretch.start - 1e-9) & (positions <= stretch.stop + 1e-9)]
            total[rows] += match.sides[side, rows]
            count[rows] += 1.0
    wanted = np.divide(total, count[:, None], out=match.targets.copy(), where=count[:, None] > 0.0)
    return Pull(wanted, np.where(count > 0.0, WEIGHT, 0.0))


def _missed(arc: FloatArray, path: FloatArray, stretch: PinnedInterval) -> float:
    """Greatest distance from a pinned stretch to the path, `LEAF` off the hinges."""
    lengths = along(arc)
    inside = lengths[(lengths > stretch.start) & (lengths < stretch.stop)]
    even = np.linspace(stretch.start, stretch.stop, 33)
    points = at(arc, lengths, np.sort(np.concatenate([even, inside])))
    near = np.minimum(np.hypot(*(points - arc[0]).T), np.hypot(*(points - arc[-1]).T)) < LEAF * L_C
    line = shapely.LineString(path)
    return float(shapely.distance(shapely.points(points[~near]), line).max(initial=0.0))

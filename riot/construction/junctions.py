"""Find where the swung arcs pass the junctions of the dissection tree, and so which section of each belongs to a tree
arc (theory §8). Ours.

All arcs that pass a junction pass it at the same corner, if some of them has a corner there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from riot.construction.tree import TreeArc, Walk, joined
from riot.construction.tuning import (
    CORNER_SLACK,
    CORNER_TURN,
    CORNER_TURN_DIFFERENCE,
    FEATURE_TURN_WINDOW,
    JUNCTION_TURN_WINDOW,
    LEAST_FEATURE_TURN,
    PARTITION_DISTANCE_WEIGHT,
    POSITION_ROUNDING,
)
from riot.geometry.polyline import simplify_open
from riot.kernels.matching import along, at, corresponding, turnings
from riot.parameters import DetailParameters
from riot.types import FloatArray
from riot.units import L_C

Sections = dict[tuple[int, int], tuple[float, float]]
"""(cell, tree arc) → positions on the cell's swung arc where the tree arc starts and where it ends."""


@dataclass(frozen=True, eq=False)
class SwungArc:
    """A swung arc (s, 2) with the position (s,) of every vertex along it, and the turn (s,) at its features, else 0."""

    points: FloatArray
    positions: FloatArray
    turns: FloatArray


def describe_arc(points: FloatArray, parameters: DetailParameters) -> SwungArc:
    """Measure a swung arc (s, 2) and mark its features."""
    turns = np.zeros(len(points))
    kept = simplify_open(points, parameters.feature * L_C)
    kept_turns = turnings(points, FEATURE_TURN_WINDOW * parameters.step * L_C)[kept]
    turns[kept] = np.where(kept_turns == 0.0, LEAST_FEATURE_TURN, kept_turns)
    turns[[0, -1]] = 0.0
    return SwungArc(points, along(points), turns)


def find_sections(
    tree: Sequence[TreeArc], walks: Sequence[Walk], arcs: Sequence[SwungArc], parameters: DetailParameters
) -> tuple[Sections, frozenset[int]]:
    """Find the section of each swung arc that belongs to each tree arc, and the junctions where some arc has a corner.

    ``arcs[k]`` belongs to cell k, ``walks[k]`` are the tree arcs around it.
    """
    step, snap = parameters.step * L_C, parameters.snap * L_C
    points = [arc.points for arc in tree]
    passing: dict[int, dict[int, float]] = {}
    corners_of: dict[tuple[int, int], list[tuple[float, FloatArray]]] = {}
    for cell, (walk, swung) in enumerate(zip(walks, arcs, strict=True)):
        path = joined(points, walk)
        stops = np.cumsum([along(points[k])[-1] for k, _ in walk])[:-1]
        positions = corresponding(path, stops, swung.points, step)
        turns = turnings(path, JUNCTION_TURN_WINDOW * step)[np.cumsum([len(points[k]) - 1 for k, _ in walk])[:-1]]
        is_corner = np.abs(swung.turns) > CORNER_TURN
        for node, position, turn in zip(_junctions(tree, walk), positions.tolist(), turns.tolist(), strict=True):
            passing.setdefault(node, {})[cell] = position
            near = np.abs(swung.positions - position) < snap
            fitting = np.flatnonzero(is_corner & near & (np.abs(swung.turns - turn) < CORNER_TURN_DIFFERENCE))
            if len(fitting):
                corners_of[node, cell] = [(float(swung.positions[k]), swung.points[k]) for k in fitting]
    partitioned = {node: arc.points[end] for arc in tree for node, end in ((arc.start, 0), (arc.end, -1))}
    for node, position_of in passing.items():
        corners = {cell: corners_of.get((node, cell), []) for cell in position_of}
        if any(corners.values()):
            _meet_at_corner(partitioned[node], position_of, corners, arcs, snap)
    sections: Sections = {}
    for cell, walk in enumerate(walks):
        inner = (passing[node][cell] for node in _junctions(tree, walk))
        bounds = np.maximum.accumulate(np.array([0.0, *inner, arcs[cell].positions[-1]]))
        for (k, forwards), (start, stop) in zip(walk, pairwise(bounds.tolist()), strict=True):
            sections[cell, k] = (start, stop) if forwards else (stop, start)
    return sections, frozenset(node for node, _ in corners_of)


def cut_section(swung: SwungArc, start: float, stop: float) -> tuple[FloatArray, FloatArray]:
    """Cut a swung arc from one position to another, backwards if need be: points (k, 2) and turns (k,) of features."""
    low, high = min(start, stop), max(start, stop)
    inside = (swung.positions > low + POSITION_ROUNDING) & (swung.positions < high - POSITION_ROUNDING)
    ends = at(swung.points, swung.positions, np.array([low, high]))
    points = np.concatenate([ends[:1], swung.points[inside], ends[1:]])
    turns = np.concatenate([[0.0], swung.turns[inside], [0.0]])
    return (points, turns) if start <= stop else (points[::-1].copy(), -turns[::-1])


def _junctions(tree: Sequence[TreeArc], walk: Walk) -> list[int]:
    """The nodes that a walk passes between its ends."""
    return [tree[k].end if forwards else tree[k].start for k, forwards in walk][:-1]


def _meet_at_corner(
    partitioned: FloatArray,
    position_of: dict[int, float],
    corners: dict[int, list[tuple[float, FloatArray]]],
    arcs: Sequence[SwungArc],
    snap: float,
) -> None:
    """Change the positions where the arcs of several cells pass one junction, so that all pass the same corner.

    ``partitioned`` (2,) is the junction of the partition. The corner that all arcs pass most nearly is taken. An arc
    that has a corner as near goes to it by that corner, the others go by their nearest point.
    """
    best, nearest = np.inf, dict[int, tuple[float, float]]()
    chosen = partitioned
    for corner in (corner for corners_of_cell in corners.values() for _, corner in corners_of_cell):
        candidates = {cell: _nearest(arcs[cell], corner, position, snap) for cell, position in position_of.items()}
        score = sum(distance for _, distance in candidates.values())
        score += PARTITION_DISTANCE_WEIGHT * float(np.hypot(*(corner - partitioned)))
        if score < best:
            best, nearest, chosen = score, candidates, corner
    for cell, (position, distance) in nearest.items():
        reach = distance + CORNER_SLACK * snap
        distances = [float(np.hypot(*(corner - chosen))) for _, corner in corners[cell]]
        position_of[cell] = position
        if distances and min(distances) <= reach:
            position_of[cell] = corners[cell][int(np.argmin(distances))][0]


def _nearest(swung: SwungArc, point: FloatArray, position: float, reach: float) -> tuple[float, float]:
    """Position of the arc's point nearest to ``point`` within ``reach`` of ``position``, and its distance."""
    low, high = max(position - reach, 0.0), min(position + reach, float(swung.positions[-1]))
    inside = swung.positions[(swung.positions > low) & (swung.positions < high)]
    stops = np.concatenate([[low], inside, [high]])
    at_stops = at(swung.points, swung.positions, stops)
    ahead = np.diff(at_stops, axis=0)
    square = (ahead**2).sum(axis=1)
    share = np.divide(((point - at_stops[:-1]) * ahead).sum(axis=1), square, out=np.zeros(len(ahead)), where=square > 0)
    share = share.clip(0.0, 1.0)
    distance = ((at_stops[:-1] + share[:, None] * ahead - point) ** 2).sum(axis=1)
    best = int(distance.argmin())
    return float(stops[best] + share[best] * (stops[best + 1] - stops[best])), float(np.sqrt(distance[best]))

"""The outline that the swung arcs of a dissection make around the other trunk, and sections of it. Ours."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely

from riot.construction.dissection import Dissection
from riot.construction.tuning import PIN_CHECKS, PIN_REACH, SECTION_SLACK
from riot.errors import PinError
from riot.kernels.matching import along
from riot.types import FloatArray


@dataclass(frozen=True, eq=False)
class PinnedSection:
    """A pinned section of the swung arc of ``cell``, from position ``start`` to ``stop`` along it."""

    cell: int
    start: float
    stop: float


class PlacedOutline:
    """The swung arcs carried out to where their pieces lie around the other trunk: the outline, in the pins' frame."""

    def __init__(self, dissection: Dissection, outer: FloatArray, arcs: Sequence[FloatArray]) -> None:
        """Carry every arc by the rigid motion of its trunk edge."""
        n = len(outer)
        self.trunk, self.inner_arcs = dissection.trunk, arcs
        self.edges = [(self.trunk[[k, (k + 1) % n]], outer[[k, (k + 1) % n]]) for k in range(n)]
        self.arcs = [carried(arc, *edge) for arc, edge in zip(arcs, self.edges, strict=True)]
        self.lengths = [along(arc) for arc in arcs]
        self.starts = np.concatenate([[0.0], np.cumsum([lengths[-1] for lengths in self.lengths])])

    def position(self, point: FloatArray, label: str) -> float:
        """Where around the outline the boundary point nearest to ``point`` is; PinError if none is near."""
        target = shapely.Point(point)
        lines = [shapely.LineString(arc) for arc in self.arcs]
        distances = shapely.distance(lines, target)
        cell = int(np.argmin(distances))
        if not distances[cell] <= PIN_REACH:
            raise PinError(
                f"{label}: ({point[0]:.4g}, {point[1]:.4g}) lies {distances[cell]:.3g} from the outline, more than "
                f"{PIN_REACH:.3g}: give a point on it (in Python, Shape.from_source converts to the shape's "
                "frame)"
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
                if high - low > SECTION_SLACK:
                    sections.append(PinnedSection(cell, low, high))
        return sections

    def checks(self, section: PinnedSection) -> FloatArray:
        """(k,) positions along a section's arc at which it is looked at: even ones and its vertices."""
        lengths = self.lengths[section.cell]
        inside = lengths[(lengths > section.start) & (lengths < section.stop)]
        return np.unique(np.concatenate([np.linspace(section.start, section.stop, PIN_CHECKS), inside]))


def carried(points: FloatArray, source: FloatArray, target: FloatArray) -> FloatArray:
    """(k, 2) points moved by the rigid motion that brings one segment (2, 2) onto another as long."""
    turn = complex(*(target[1] - target[0])) / complex(*(source[1] - source[0]))
    turn /= abs(turn)
    moved = (points - source[0]) @ np.array([[turn.real, turn.imag], [-turn.imag, turn.real]]) + target[0]
    return np.asarray(moved)

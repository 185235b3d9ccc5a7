"""Poses of a chain of pieces: closed as P, closed as Q, and every position between (theory §1, §9).

A chain is a list of edge lengths and the turns between consecutive edges. Closed one way the turns at the hinges are
π − α_j (the trunk T is on the left of every edge), closed the other way they are −(π − ᾱ_j) (T̄ is on the right).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from riot.content import ByContent, count
from riot.types import FloatArray


@dataclass(frozen=True)
class Placement:
    """Where the first piece's edge starts in a shape's frame, and where it points (radians)."""

    x: float
    y: float
    heading: float

    @classmethod
    def of(cls, trunk: FloatArray) -> Placement:
        """Of the piece on the first edge of a trunk (n, 2)."""
        edge = trunk[1] - trunk[0]
        return cls(float(trunk[0, 0]), float(trunk[0, 1]), math.atan2(edge[1], edge[0]))


@dataclass(frozen=True, eq=False)
class Pose(ByContent):
    """One position of the chain.

    Parameters
    ----------
    t : float
        0 is P, 1 is Q.
    headings : (n,) float64
        Direction of every piece's edge, radians.
    origins : (n, 2) float64
        Where every piece's (0, 0) lies.
    """

    t: float
    headings: FloatArray
    origins: FloatArray

    def __repr__(self) -> str:
        return f"Pose(t={self.t:g}, {count(len(self.headings), 'piece')})"

    def place(self, piece: int, points: FloatArray) -> FloatArray:
        """Map (k, 2) points of a piece's frame to where this pose has them."""
        placed: FloatArray = rotate(points, float(self.headings[piece])) + self.origins[piece]
        return placed


@dataclass(frozen=True, eq=False)
class Chain(ByContent):
    """Lengths of the edges, and the trunk angles at hinge j (start of edge j) closed as P and closed as Q."""

    lengths: FloatArray
    angles: FloatArray
    conjugate_angles: FloatArray

    def __repr__(self) -> str:
        return f"Chain({count(len(self.lengths), 'piece')})"

    def turns(self, t: float) -> FloatArray:
        """(n,) turn at every hinge at time t, radians, counter-clockwise positive."""
        turns: FloatArray = (1.0 - t) * (math.pi - self.angles) - t * (math.pi - self.conjugate_angles)
        return turns


def rotate(points: FloatArray, angle: float) -> FloatArray:
    """Turn (k, 2) points about the origin, counter-clockwise, by ``angle`` radians.

    >>> rotate(np.array([[1.0, 0.0]]), math.pi / 2).round(9).tolist()
    [[0.0, 1.0]]
    """
    c, s = math.cos(angle), math.sin(angle)
    turned: FloatArray = points @ np.array([[c, s], [-s, c]])
    return turned


def direction(heading: float) -> FloatArray:
    """(2,) unit vector of a heading in radians.

    >>> direction(math.pi).round(9).tolist()
    [-1.0, 0.0]
    """
    return np.array([math.cos(heading), math.sin(heading)])


def lay(chain: Chain, t: float, open_hinge: int = 0, turns: FloatArray | None = None) -> Pose:
    """Lay the chain from the piece after the open hinge, that piece's edge on the x-axis from the origin.

    Its hinges are turned by ``turns`` (n,), radians; without them by those of an even swing at time t.

    >>> lay(transform.chain, 0.0).origins.shape
    (4, 2)
    """
    n = len(chain.lengths)
    turns = chain.turns(t) if turns is None else turns
    headings, origins = np.zeros(n), np.zeros((n, 2))
    for k in range(1, n):
        before, after = (open_hinge + k - 1) % n, (open_hinge + k) % n
        headings[after] = headings[before] + turns[after]
        origins[after] = origins[before] + chain.lengths[before] * direction(headings[before])
    return Pose(t, headings, origins)


def swing(
    chain: Chain,
    place_p: Placement,
    place_q: Placement,
    t: float,
    open_hinge: int = 0,
    turns: FloatArray | None = None,
) -> Pose:
    """The chain at time t; piece 0 lies as ``place_p`` at 0 and as ``place_q`` at 1.

    Every hinge turns evenly, or is turned by ``turns`` (n,), radians. Between the ends the chain as a whole turns
    evenly, by the least total turn of its mean heading, and the mean of its edges' middles moves on a straight line.

    >>> start = swing(transform.chain, transform.place_p, transform.place_q, 0.0)
    >>> bool(np.allclose(start.origins, transform.pose(0.0).origins))
    True
    """
    closed_p, closed_q = lay(chain, 0.0, open_hinge), lay(chain, 1.0, open_hinge)
    turn_p = place_p.heading - float(closed_p.headings[0])
    turn_q = place_q.heading - float(closed_q.headings[0])
    change = turn_q + float(closed_q.headings.mean()) - turn_p - float(closed_p.headings.mean())
    turn_q -= 2.0 * math.pi * round(change / (2.0 * math.pi))
    middle_p = _middle_when_placed(chain, closed_p, turn_p, place_p)
    middle_q = _middle_when_placed(chain, closed_q, turn_q, place_q)

    raw = lay(chain, t, open_hinge, turns)
    uneven = (1.0 - t) * closed_p.headings.mean() + t * closed_q.headings.mean() - raw.headings.mean()
    turned = _turned(raw, (1.0 - t) * turn_p + t * turn_q + float(uneven))
    shift = (1.0 - t) * middle_p + t * middle_q - _middle(chain, turned)
    return Pose(t, turned.headings, turned.origins + shift)


def _turned(pose: Pose, angle: float) -> Pose:
    return Pose(pose.t, pose.headings + angle, rotate(pose.origins, angle))


def _middle(chain: Chain, pose: Pose) -> FloatArray:
    ends = np.stack([np.cos(pose.headings), np.sin(pose.headings)], axis=1) * chain.lengths[:, None]
    middle: FloatArray = (pose.origins + 0.5 * ends).mean(axis=0)
    return middle


def _middle_when_placed(chain: Chain, pose: Pose, turn: float, placement: Placement) -> FloatArray:
    turned = _turned(pose, turn)
    middle: FloatArray = _middle(chain, turned) - turned.origins[0] + np.array([placement.x, placement.y])
    return middle

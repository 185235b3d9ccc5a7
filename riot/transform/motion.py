"""The motion of a chain from P to Q, as key frames (theory §9). Ours."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from riot.content import ByContent, count
from riot.transform.pose import Chain, Placement, Pose, swing
from riot.types import FloatArray, IntArray

SEARCHES = ("together", "one by one", "through the straight chain", "straight, one by one", "sampled")
"""How hinges turn, by name, the calmest first: all evenly from P to Q; one after another in some order; all to the
straight chain and on; one after another with a stop when straight; from pose to pose between random ones."""


LIFT = 0.1
"""Share of the whole time for lifting, and as much for lowering, if hinges lift (ours).

It stands here and not with the numbers of certificates, on which constructions depend.
"""


@dataclass(frozen=True)
class Attempt:
    """One search for a way of ``pieces`` neighbouring pieces from piece ``first`` on, alone in their plane.

    ``checks`` counts the poses of two pieces that were tested for collision.
    """

    first: int
    pieces: int
    search: str
    free: bool
    checks: int


@dataclass(frozen=True, eq=False)
class Motion(ByContent):
    """How the n pieces of a transform swing from P to Q without collision.

    Parameters
    ----------
    open_hinge : int
        The hinge that is open: it joins nothing.
    lifted : tuple of int
        Telescopic hinges, in chain order from the open one: the pieces after one move in the next higher plane.
    search : str
        The least calm of the searches (`SEARCHES`) that found the ways of its subchains.
    times : (k,) float64
        Of the key frames, from 0 (P) to 1 (Q), increasing.
    turns : (k, n) float64
        Turn at every hinge at each of them, radians, counter-clockwise positive; between two frames hinges turn evenly.
        That of the open hinge means nothing.
    levels : (k, n) int64
        The plane of every piece at each key frame, 0 = the ground; pieces of different planes do not meet.
    gap, relief : float
        Outline gap between pieces, and radius of the discs around hinges in which the hinge's two pieces do not count,
        in the unit-area frame.
    tried : tuple of Attempt
        Every search, in order: what is shown to be free, and what was tried before hinges had to lift.
    chain, place_p, place_q
        Of the transform.
    """

    open_hinge: int
    lifted: tuple[int, ...]
    search: str
    times: FloatArray
    turns: FloatArray
    levels: IntArray
    gap: float
    relief: float
    tried: tuple[Attempt, ...]
    chain: Chain
    place_p: Placement
    place_q: Placement

    def __repr__(self) -> str:
        return f"Motion({count(len(self.chain.lengths), 'piece')}, {self.words}, {count(len(self.times), 'key frame')})"

    @property
    def flat(self) -> bool:
        """Whether all pieces stay in one plane."""
        return not self.lifted

    @property
    def words(self) -> str:
        """What a puzzler needs to know."""
        if self.flat:
            return "swings flat"
        return f"needs {len(self.lifted)} telescopic hinge{'s' if len(self.lifted) > 1 else ''}"

    @property
    def checks(self) -> int:
        """Poses of two pieces that all searches tested for collision."""
        return sum(attempt.checks for attempt in self.tried)

    def turns_at(self, t: float) -> FloatArray:
        """(n,) turn at every hinge at time t in [0, 1]."""
        return np.array([np.interp(t, self.times, self.turns[:, h]) for h in range(self.turns.shape[1])])

    def levels_at(self, t: float) -> FloatArray:
        """(n,) height of every piece at time t, in planes: whole numbers but while lifting and lowering."""
        return np.array([np.interp(t, self.times, self.levels[:, i]) for i in range(self.levels.shape[1])])

    def pose_at(self, t: float) -> Pose:
        """The chain at time t in [0, 1]: P in P's frame at 0, Q in Q's at 1; t outside counts as the nearer end.

        In between, the chain as a whole turns evenly and the mean of its edges' middles moves on a straight line.
        Headings are continuous in t: at 1 they may be whole turns away from those of the closed Q.
        """
        t = min(1.0, max(0.0, t))
        if t == 0.0:
            return self._closed[0]
        if t == 1.0:
            closed, last = self._closed[1], self._raw(1.0)
            wound = np.round((last.headings + self._winding - closed.headings) / (2.0 * math.pi))
            return Pose(1.0, closed.headings + 2.0 * math.pi * wound, closed.origins)
        pose = self._raw(t)
        return Pose(t, pose.headings + self._winding, pose.origins)

    def _raw(self, t: float) -> Pose:
        first, last = (0.0, 1.0) if self.flat else (LIFT, 1.0 - LIFT)
        carried = min(1.0, max(0.0, (t - first) / (last - first)))
        return swing(self.chain, self.place_p, self.place_q, carried, self.open_hinge, self.turns_at(t))

    @cached_property
    def _closed(self) -> tuple[Pose, Pose]:
        p, q = (swing(self.chain, self.place_p, self.place_q, t) for t in (0.0, 1.0))
        return p, q

    @cached_property
    def _winding(self) -> FloatArray:
        """(n,) whole turns, in radians, between headings counted from the open hinge and those of the closed P."""
        turns = np.round((self._closed[0].headings - self._raw(0.0).headings) / (2.0 * math.pi))
        winding: FloatArray = 2.0 * math.pi * turns
        return winding

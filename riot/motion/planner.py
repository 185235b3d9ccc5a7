"""Plan a motion: which hinge opens, how the others turn, and which of them must lift, if any (theory §9). Ours.

The ring of pieces is cut at the open hinge and at every hinge that lifts. Each subchain between two cuts keeps to a
plane of its own, one level above the subchain before, so that subchains do not meet: a set of cuts is enough if each
subchain has a free way by itself. If a subchain has none, a longer one that contains it has none either.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from riot import motion  # lazy: a motion that a transform carries is not searched
from riot.parameters import MotionParameters as MotionParameters
from riot.transform.motion import LIFT, SEARCHES
from riot.transform.motion import Attempt as Attempt
from riot.transform.motion import Motion as Motion
from riot.transform.pose import Chain
from riot.transform.transform import Transform
from riot.transform.transform_cache import once_per_transform
from riot.types import FloatArray, IntArray

if TYPE_CHECKING:
    from riot.motion.bodies import Bodies


def plan_motion(transform: Transform, parameters: MotionParameters | None = None) -> Motion:
    """Plan how the pieces swing from P to Q without collision (theory §9); the same transform gives the same motion.

    Every open hinge is tried, by each search in turn (`riot.transform.motion.SEARCHES`): a motion in one plane wins
    over any with lifts, and among those a calm one. There always is a plan: with all hinges lifting, no two pieces
    share a plane. Ours.

    >>> from riot.groundtruth.pairs import dudeney, exact_transform
    >>> motion = plan_motion(exact_transform(dudeney()))
    >>> motion.words, motion.search
    ('swings flat', 'together')
    """
    parameters = parameters or MotionParameters()
    bodies = motion.bodies.make_bodies(transform, parameters)
    planner = _Planner(transform.chain, bodies, parameters)
    cuts, ways = planner.flat() or planner.lifting()
    return _motion(transform, bodies, cuts, ways, tuple(planner.tried))


def motion_of(transform: Transform) -> Motion:
    """The motion that a transform carries as its ``plan``; without one, that of default parameters, planned once.

    >>> from riot.groundtruth.pairs import dudeney, exact_transform
    >>> transform = exact_transform(dudeney())
    >>> motion_of(transform) is motion_of(transform)
    True
    """
    return _default_motion(transform) if transform.plan is None else transform.plan


def with_motion(transform: Transform) -> Transform:
    """The transform with its motion as ``plan``, to be saved with it.

    >>> from riot.groundtruth.pairs import dudeney, exact_transform
    >>> with_motion(exact_transform(dudeney())).plan.flat
    True
    """
    return replace(transform, plan=motion_of(transform))


_default_motion = once_per_transform(plan_motion)

Way = tuple[int, FloatArray]
"""Which of `SEARCHES` found it, and the path."""


class _Planner:
    def __init__(self, chain: Chain, bodies: Bodies, parameters: MotionParameters) -> None:
        self.tried: list[Attempt] = []
        self._n = len(chain.lengths)
        self._bodies, self._parameters = bodies, parameters
        self._turns = chain.turns(0.0), chain.turns(1.0)
        self._ways: dict[tuple[int, int], Way | None] = {}
        self._begun: dict[tuple[int, int], int] = {}
        """How many of the searches a subchain has seen in vain."""

    def flat(self) -> tuple[tuple[int, ...], list[Way]] | None:
        """The open hinge and the way of the whole chain in one plane; None if there is none."""
        stuck = [hinge for hinge in range(self._n) if self._way((hinge - 1) % self._n, 2) is None]
        opened = [hinge for hinge in range(self._n) if not set(stuck) - {hinge}]
        for search in range(len(SEARCHES) - 1):
            for hinge in opened:
                way = self._try(hinge, self._n, search)
                if way is not None:
                    return (hinge,), [way]
        for hinge in opened:
            way = self._way(hinge, self._n)
            if way is not None:
                return (hinge,), [way]
        return None

    def lifting(self) -> tuple[tuple[int, ...], list[Way]]:
        """The fewest cuts that leave a free way to every subchain, and the ways; the calmest among equals."""
        for count in range(2, self._n + 1):
            best: tuple[int, tuple[int, ...], list[Way]] | None = None
            for cuts in combinations(range(self._n), count):
                ways = [self._way(first, size) for first, size in _subchains(cuts, self._n)]
                free_ways = [way for way in ways if way is not None]
                effort = sum(rank for rank, _ in free_ways)
                if len(free_ways) == count and (best is None or effort < best[0]):
                    best = effort, cuts, free_ways
            if best is not None:
                return best[1:]
        raise AssertionError("a chain of single pieces has no way")

    def _way(self, first: int, size: int) -> Way | None:
        """The way of a subchain by the first search that finds one."""
        key = first % self._n, size
        if size == 1:
            return 0, np.empty((1, 0))
        if key not in self._ways:
            # One hinge has one way.
            last = 1 if size == 2 else len(SEARCHES)
            if size > 2 and any(self._way(key[0] + k, size - 1) is None for k in (0, 1)):
                last = 0
            for search in range(self._begun.get(key, 0), last):
                if self._try(*key, search) is not None:
                    break
            self._ways.setdefault(key, None)
        return self._ways[key]

    def _try(self, first: int, size: int, search: int) -> Way | None:
        pieces = (first + np.arange(size)) % self._n
        start, goal = (turns[pieces[1:]] for turns in self._turns)
        subchain = motion.search.Subchain(self._bodies, pieces, start, goal)
        path = motion.search.find_path(subchain, SEARCHES[search], self._parameters.samples, self._parameters.seed)
        self.tried.append(Attempt(first, size, SEARCHES[search], path is not None, subchain.checks))
        self._begun[first, size] = search + 1
        if path is None:
            return None
        way = search, path
        self._ways[first, size] = way
        return way


def _subchains(cuts: tuple[int, ...], n: int) -> list[tuple[int, int]]:
    """First piece and number of pieces from every cut to the next, the last to the first."""
    return [(cut, (following - cut - 1) % n + 1) for cut, following in zip(cuts, (*cuts[1:], cuts[0]), strict=True)]


def _motion(
    transform: Transform, bodies: Bodies, cuts: tuple[int, ...], ways: list[Way], tried: tuple[Attempt, ...]
) -> Motion:
    """Put the ways of the subchains together: all start and arrive at the same time."""
    n, chain = len(transform), transform.chain
    clocks = [_clock(path) for _, path in ways]
    times = np.unique(np.concatenate([[0.0, 1.0], *clocks]))
    turns = np.array([chain.turns(float(t)) for t in times])
    level: IntArray = np.zeros(n, dtype=np.int64)
    for k, ((first, size), clock, (_, path)) in enumerate(zip(_subchains(cuts, n), clocks, ways, strict=True)):
        pieces = (first + np.arange(size)) % n
        level[pieces] = k
        for h, piece in enumerate(pieces[1:]):
            turns[:, piece] = np.interp(times, clock, path[:, h])
    levels = np.tile(level, (len(times), 1))
    if len(cuts) > 1:
        ground = np.zeros((1, n), dtype=np.int64)
        times = np.concatenate([[0.0], LIFT + (1.0 - 2.0 * LIFT) * times, [1.0]])
        turns = np.concatenate([turns[:1], turns, turns[-1:]])
        levels = np.concatenate([ground, levels, ground])
    search = SEARCHES[max(rank for rank, _ in ways)]
    return Motion(
        open_hinge=cuts[0],
        lifted=cuts[1:],
        search=search,
        times=times,
        turns=turns,
        levels=levels,
        gap=bodies.gap,
        relief=bodies.relief,
        tried=tried,
        chain=chain,
        place_p=transform.place_p,
        place_q=transform.place_q,
    )


def _clock(path: FloatArray) -> FloatArray:
    """(k,) times from 0 to 1 of a path's stops: as long as the greatest turn between them takes."""
    if path.shape[1] == 0:
        return np.zeros(len(path))
    spent = np.abs(np.diff(path, axis=0)).max(axis=1)
    clock: FloatArray = np.concatenate([[0.0], np.cumsum(spent) / spent.sum()])
    clock[-1] = 1.0
    return clock

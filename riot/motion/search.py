"""Search for a path of one subchain from its turns in P to those in Q (theory §9). Ours.

A path is a (k, m − 1) array of the turns of a subchain of m pieces, hinges turning evenly between two rows.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from riot.kernels.collide import clear_share
from riot.motion.bodies import Bodies
from riot.motion.tuning import (
    CONTACT_SHARE,
    DISTANCE_CAP,
    LEAST_STEP,
    MOST_ORDERED_TURNS,
    POSE_SPREAD,
    STEP_BACK,
    UNIFORM_SHARE,
)
from riot.types import FloatArray, IntArray


class Subchain:
    """Neighbouring pieces of the chain, in order, with a count of the poses of pairs that were looked at."""

    def __init__(self, bodies: Bodies, pieces: IntArray, start: FloatArray, goal: FloatArray) -> None:
        self.start, self.goal = start, goal
        self.checks = 0
        self._arrays = bodies.subchain(pieces)
        self._floor = CONTACT_SHARE * 0.5 * bodies.gap

    def share(self, before: FloatArray, after: FloatArray, *, whole: bool = False) -> float:
        """How far the way from one pose to another is proven free; with ``whole`` it may be less than that."""
        share, checks = clear_share(*self._arrays, before, after, self._floor, DISTANCE_CAP, whole)
        self.checks += checks
        return float(share)

    def free(self, path: FloatArray) -> bool:
        """Whether a whole path is."""
        return all(self.share(a, b, whole=True) >= 1.0 for a, b in pairwise(path))


def find_path(subchain: Subchain, search: str, samples: int, seed: int) -> FloatArray | None:
    """Find a free path (k, m − 1) by one of `riot.transform.motion.SEARCHES`; None if that finds none.

    ``samples`` is the number of random poses, ``seed`` theirs, of the search "sampled".
    """
    turns = len(subchain.start)
    straight = np.zeros(turns)
    if search == "together":
        path = np.array([subchain.start, subchain.goal])
        return path if subchain.free(path) else None
    if search == "through the straight chain":
        path = np.array([subchain.start, straight, subchain.goal])
        return path if subchain.free(path) else None
    if search == "sampled":
        path_with_detours = _sampled(subchain, samples, seed)
    elif turns >= MOST_ORDERED_TURNS:
        return None
    else:
        stops = [subchain.start, subchain.goal] if search == "one by one" else [subchain.start, straight, subchain.goal]
        path_with_detours = _ordered(subchain, np.array(stops))
    return None if path_with_detours is None else shorter(subchain, path_with_detours)


def _ordered(subchain: Subchain, stops: FloatArray) -> FloatArray | None:
    """A path on which one hinge turns at a time, from stop to stop: any order, the chain's own first."""
    turns = len(subchain.start)
    last = len(stops) - 1
    dead: set[tuple[int, ...]] = set()

    def at(state: tuple[int, ...]) -> FloatArray:
        return np.array([stops[stop, h] for h, stop in enumerate(state)])

    def onward(state: tuple[int, ...]) -> Iterator[tuple[int, ...]]:
        for h in range(turns):
            if state[h] < last:
                yield (*state[:h], state[h] + 1, *state[h + 1 :])

    def descend(state: tuple[int, ...]) -> list[FloatArray] | None:
        if min(state) == last:
            return [at(state)]
        for following in onward(state):
            if following not in dead and subchain.share(at(state), at(following), whole=True) >= 1.0:
                rest = descend(following)
                if rest is not None:
                    return [at(state), *rest]
        dead.add(state)
        return None

    stops_in_order = descend((0,) * turns)
    return None if stops_in_order is None else np.array(stops_in_order)


def _sampled(subchain: Subchain, samples: int, seed: int) -> FloatArray | None:
    """Two trees of poses, from P and from Q, that grow towards random poses and each other (RRT-Connect).

    Poses are drawn between the turns in P and those in Q: beyond them a hinge's two pieces would meet.
    """
    whole = subchain.goal - subchain.start
    rng = np.random.default_rng(seed)
    trees = (_Tree(subchain.start), _Tree(subchain.goal))
    for k in range(samples):
        mine, other = trees[k % 2], trees[1 - k % 2]
        if rng.random() < UNIFORM_SHARE:
            shares = rng.random(len(whole))
        else:
            known = (mine.poses[int(rng.integers(len(mine.poses)))] - subchain.start) / whole
            shares = np.clip(known + POSE_SPREAD * rng.standard_normal(len(whole)), 0.0, 1.0)
        grown = mine.grow(subchain, subchain.start + shares * whole, whole)
        if grown is None:
            continue
        target = mine.poses[grown]
        while (reached := other.grow(subchain, target, whole)) is not None:
            if np.array_equal(other.poses[reached], target):
                halves = (mine.branch(grown), other.branch(reached))
                first, second = halves if k % 2 == 0 else halves[::-1]
                return np.concatenate([first[::-1], second[1:]])
    return None


class _Tree:
    """Poses joined by free ways to the first."""

    def __init__(self, root: FloatArray) -> None:
        self.poses = [root]
        self.parents = [-1]

    def grow(self, subchain: Subchain, target: FloatArray, whole: FloatArray) -> int | None:
        """Go from the nearest pose towards a target as far as the way is free; the new pose, None if too near."""
        shares = (np.array(self.poses) - target) / whole
        nearest = int(np.argmin((shares * shares).sum(axis=1)))
        far = float(np.sqrt((shares[nearest] ** 2).sum()))
        share = subchain.share(self.poses[nearest], target)
        if share < 1.0:
            share *= STEP_BACK
            if share * far < LEAST_STEP:
                return None
            target = self.poses[nearest] + share * (target - self.poses[nearest])
        self.poses.append(target)
        self.parents.append(nearest)
        return len(self.poses) - 1

    def branch(self, node: int) -> FloatArray:
        """(k, m − 1) poses from a node back to the root."""
        poses = []
        while node >= 0:
            poses.append(self.poses[node])
            node = self.parents[node]
        return np.array(poses)


def shorter(subchain: Subchain, path: FloatArray) -> FloatArray:
    """The path without the stops that can be left out, farthest first."""
    kept = [path[0]]
    k = 0
    while k < len(path) - 1:
        k = next(j for j in range(len(path) - 1, k, -1) if j == k + 1 or subchain.free(path[[k, j]]))
        kept.append(path[k])
    return np.array(kept)

"""Key frames and marks of every picture of a motion, higher planes painted over lower ones (theory §9). Ours."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from riot.draw.scene import Box, Dot, Mark, PlacedPiece, around, swept
from riot.draw.tuning import LIFTING_RADIUS, LOOP_SECONDS, MAX_TURN, PAUSE_FRAMES, WAY_FRAMES
from riot.transform.motion import LIFT, Motion
from riot.transform.pose import direction
from riot.transform.transform import Transform
from riot.types import FloatArray


@dataclass(frozen=True, eq=False)
class Keyframes:
    """The n pieces at k times: (k, n) headings, radians, and (k, n, 2) origins, as `Pose` has them."""

    headings: FloatArray
    origins: FloatArray


@dataclass(frozen=True, eq=False)
class Knots:
    """Poses of a motion: k ``times``, (k, n) ``headings``, radians, and (k, 2) ``middles``, the mean of the middles of
    the n edges."""

    times: FloatArray
    headings: FloatArray
    middles: FloatArray


def eased(frames: int) -> FloatArray:
    """(frames + 1,) times from 0 to 1, slow at both ends.

    >>> eased(2).round(9).tolist()
    [0.0, 0.5, 1.0]
    """
    steps = np.linspace(0.0, 1.0, frames + 1)
    times: FloatArray = 0.5 - 0.5 * np.cos(np.pi * steps)
    return times


def loop_seconds(frames: int) -> float:
    """Length of a loop of ``frames`` each way.

    >>> loop_seconds(40)
    8.0
    """
    return LOOP_SECONDS * (frames + PAUSE_FRAMES) / (WAY_FRAMES + PAUSE_FRAMES)


def keyframes(motion: Motion, times: FloatArray) -> Keyframes:
    """Compute `Motion.pose_at` at all ``times`` (k,) in [0, 1] at once.

    Poses are asked for at the `knots` alone; at the other times the pieces are laid one after another, and then all
    together where they belong.
    """
    known = knots(motion)
    headings = _between(times, known.times, known.headings)
    n = len(motion.chain.lengths)
    edges = _edges(motion, headings)
    chain = (motion.open_hinge + np.arange(n)) % n
    origins = np.zeros_like(edges)
    origins[:, chain[1:]] = np.cumsum(edges[:, chain[:-1]], axis=1)
    middles = _between(times, known.times, known.middles)
    return Keyframes(headings, origins + (middles - _middle(origins, edges))[:, None])


def knots(motion: Motion) -> Knots:
    """The few poses from which all others follow: between two of them headings and middles change evenly.

    >>> from riot.motion import motion_of
    >>> knots(motion_of(transform)).headings.shape[1]  # pieces
    4
    """
    carried = () if motion.flat else (LIFT, 1.0 - LIFT)
    times = np.unique([0.0, *carried, 1.0, *motion.times])
    poses = [motion.pose_at(float(t)) for t in times]
    headings = np.array([pose.headings for pose in poses])
    return Knots(times, headings, _middle(np.array([pose.origins for pose in poses]), _edges(motion, headings)))


def _between(times: FloatArray, knots: FloatArray, values: FloatArray) -> FloatArray:
    """(k, m) values at ``times``, of columns known at the knots."""
    return np.stack([np.interp(times, knots, column) for column in values.T], axis=1)


def _edges(motion: Motion, headings: FloatArray) -> FloatArray:
    """(k, n, 2) trunk edges of pieces with these headings (k, n)."""
    edges: FloatArray = np.stack([np.cos(headings), np.sin(headings)], axis=-1) * motion.chain.lengths[:, None]
    return edges


def _middle(origins: FloatArray, edges: FloatArray) -> FloatArray:
    """(k, 2) mean of the edges' middles."""
    middle: FloatArray = (origins + 0.5 * edges).mean(axis=1)
    return middle


def frame_count(motion: Motion, frames: int = WAY_FRAMES) -> int:
    """How many frames one way needs, at least ``frames``, so that between `eased` times no piece turns too far.

    >>> from riot.groundtruth.pairs import dudeney, exact_transform
    >>> from riot.motion import motion_of
    >>> frame_count(motion_of(exact_transform(dudeney()))) >= 40
    True
    """
    fine = keyframes(motion, eased(8 * frames)).headings
    fastest = float(np.abs(np.diff(fine, axis=0)).max()) * 8.0
    return max(frames, math.ceil(frames * fastest / MAX_TURN))


def swept_box(drawn: Transform, poses: Keyframes, margin: float) -> Box:
    """The smallest box around all pieces in all poses, and a margin."""
    boxes = (swept(piece.polygon, poses.headings[:, i], poses.origins[:, i]) for i, piece in enumerate(drawn.pieces))
    return around(boxes, margin)


def painting_order(motion: Motion) -> list[int]:
    """The pieces in the order in which they are painted: by plane, then along the chain from the open hinge.

    >>> from riot.groundtruth.pairs import dudeney, exact_transform
    >>> from riot.motion import motion_of
    >>> sorted(painting_order(motion_of(exact_transform(dudeney()))))
    [0, 1, 2, 3]
    """
    n = len(motion.chain.lengths)
    top = motion.levels.max(axis=0)
    return sorted(range(n), key=lambda i: (top[i], (i - motion.open_hinge) % n))


def hinge_dot(motion: Motion, hinge: int, x: float, y: float) -> Dot:
    """The dot of a hinge: a ring for the open one, larger for those that lift.

    >>> from riot.motion import motion_of
    >>> motion = motion_of(transform)
    >>> hinge_dot(motion, motion.open_hinge, 0.0, 1.0).pen
    'open'
    """
    if hinge == motion.open_hinge:
        return Dot(x, y, "open")
    return Dot(x, y, "hinge", LIFTING_RADIUS) if hinge in motion.lifted else Dot(x, y, "hinge")


def motion_marks(drawn: Transform, motion: Motion, t: float) -> list[Mark]:
    """The pieces at time t of the motion, hinges on top, the open one as rings at its two ends.

    >>> from riot.motion import motion_of
    >>> len(motion_marks(transform, motion_of(transform), 0.5))  # four pieces, four hinges and the open end
    9
    """
    pose, n = motion.pose_at(t), len(drawn)
    origins = [(float(x), float(y)) for x, y in pose.origins]
    marks: list[Mark] = [PlacedPiece(i, *origins[i], float(pose.headings[i])) for i in painting_order(motion)]
    marks += [hinge_dot(motion, i, *origins[i]) for i in range(n)]
    last = (motion.open_hinge - 1) % n
    x, y = pose.origins[last] + drawn.pieces[last].length * direction(float(pose.headings[last]))
    return [*marks, Dot(float(x), float(y), "open")]

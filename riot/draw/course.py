"""What every picture of the motion shows: the poses of the plan, higher planes over lower ones (theory §9). Ours."""

from __future__ import annotations

import math

import numpy as np

from riot.draw.scene import Dot, Mark, Part
from riot.motion import Motion
from riot.pose import direction
from riot.shape import FloatArray
from riot.transform import Transform

STEP = math.radians(10.0)
"""Most that a piece turns between two frames, so that straight steps look rigid."""

LIFTING = 4.5
"""Radius of a telescopic hinge's dot, in pens."""


FRAMES = 40
"""Frames of one way, or more if pieces turn far."""

REST = 14
"""Frames of one pause."""

SECONDS = 8.0
"""One loop of `FRAMES`: a pause as P, the way there, a pause as Q, the way back. More frames take longer."""


def eased(frames: int) -> FloatArray:
    """(frames + 1,) times from 0 to 1, slow at both ends."""
    steps = np.linspace(0.0, 1.0, frames + 1)
    times: FloatArray = 0.5 - 0.5 * np.cos(np.pi * steps)
    return times


def loop_seconds(frames: int) -> float:
    """Length of a loop of ``frames`` each way."""
    return SECONDS * (frames + REST) / (FRAMES + REST)


def calm(motion: Motion, frames: int = FRAMES) -> int:
    """Frames of the way, at least so many, for `eased` times between which no piece turns by more than `STEP`."""
    fine = [motion.pose_at(float(t)).headings for t in eased(8 * frames)]
    fastest = float(np.abs(np.diff(fine, axis=0)).max()) * 8.0
    return max(frames, math.ceil(frames * fastest / STEP))


def stacking(motion: Motion) -> list[int]:
    """The pieces in the order in which they are painted: by plane, then along the chain from the open hinge."""
    n = len(motion.chain.lengths)
    top = motion.levels.max(axis=0)
    return sorted(range(n), key=lambda i: (top[i], (i - motion.open_hinge) % n))


def hinge_dot(motion: Motion, hinge: int, x: float, y: float) -> Dot:
    """The dot of a hinge: a ring for the open one, larger for those that lift."""
    if hinge == motion.open_hinge:
        return Dot(x, y, "open")
    return Dot(x, y, "hinge", LIFTING) if hinge in motion.lifted else Dot(x, y, "hinge")


def motion_marks(drawn: Transform, motion: Motion, t: float) -> list[Mark]:
    """The pieces at time t of the motion, hinges on top, the open one as rings at its two ends."""
    pose, n = motion.pose_at(t), len(drawn)
    places = [(float(x), float(y)) for x, y in pose.origins]
    marks: list[Mark] = [Part(i, *places[i], float(pose.headings[i])) for i in stacking(motion)]
    marks += [hinge_dot(motion, i, *places[i]) for i in range(n)]
    last = (motion.open_hinge - 1) % n
    x, y = pose.origins[last] + drawn.pieces[last].length * direction(float(pose.headings[last]))
    return [*marks, Dot(float(x), float(y), "open")]

"""The swing as an animated SVG: SMIL only, so that it moves wherever SVG is shown, without script. Ours."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from riot.draw.course import quiet_hinge
from riot.draw.panels import pose_marks, sketch
from riot.draw.scene import Dot, Scene, around, extent
from riot.draw.svg import dot, naming, painted, place, whole
from riot.pose import Pose
from riot.shape import FloatArray
from riot.transform import Transform

SECONDS = 8.0
"""One loop: a pause as P, the swing, a pause as Q, the swing back."""

FRAMES = 40
"""Key frames of one swing. A piece turns by at most a few degrees between two, so that straight steps look rigid."""

REST = 14
"""Key frames of one pause."""

STILL = 0.35
"""The pose for those who asked for less motion."""

MOTION_STYLE = (
    ".r-still{display:none}@media (prefers-reduced-motion:reduce){.r-still{display:inline}.r-move{display:none}}"
)
"""Rules that put the still pose in the place of the animation."""

_PENS_ACROSS = 520.0


@dataclass(frozen=True, eq=False)
class Swing:
    """A scene (the still pose, in a box that every pose fits) and the SVG body of the animation within it."""

    scene: Scene
    body: str


def animate_svg(transform: Transform) -> str:
    """The swing from P to Q and back, as a whole animated SVG file of deterministic text.

    Every piece has key frames of translation and rotation, eased at both ends; hinges are dots, the ends of the open
    hinge rings. Pieces may overlap on the way: the hinge that makes them overlap least is the open one.
    """
    prefix = naming(sketch(transform).pieces)
    swing = swing_of(transform, prefix, quiet_hinge(transform))
    return whole(swing.scene, swing.body, prefix, style=MOTION_STYLE)


def swing_of(transform: Transform, prefix: str, hinge: int) -> Swing:
    """The animation, open at ``hinge``, for pieces defined under ``prefix`` (see `riot.draw.svg.definitions`)."""
    drawn = sketch(transform)
    there = [drawn.pose(t, hinge) for t in eased(FRAMES)]
    poses = there[:1] * (REST // 2) + there + there[-1:] * REST + there[-2:0:-1] + there[:1] * (REST // 2)
    # The path between two key frames leaves the frames' own box by the height of an arc of a few degrees.
    box = around((extent(pose_marks(drawn, pose, hinge), drawn.pieces) for pose in there), margin=0.05)
    pen = (box[2] - box[0]) / _PENS_ACROSS
    names = transform.p.name or "P", transform.q.name or "Q"
    title = f"{len(drawn)} hinged pieces swing from {names[0]} to {names[1]} and back"
    still = tuple(pose_marks(drawn, drawn.pose(STILL, hinge), hinge))
    scene = Scene(title, box, pen, drawn.pieces, still)
    order = [(hinge + k) % len(drawn) for k in range(len(drawn))]
    moving = "".join(_piece(drawn, i, poses, prefix, pen, hinge) for i in order)
    body = f'<g class="r-move">{moving}</g><g class="r-still">{painted(scene, prefix)}</g>'
    return Swing(scene, body)


def eased(frames: int) -> FloatArray:
    """(frames + 1,) times from 0 to 1, slow at both ends."""
    steps = np.linspace(0.0, 1.0, frames + 1)
    times: FloatArray = 0.5 - 0.5 * np.cos(np.pi * steps)
    return times


def _piece(drawn: Transform, i: int, poses: list[Pose], prefix: str, pen: float, hinge: int) -> str:
    moves = ";".join(place(float(pose.origins[i, 0]), float(pose.origins[i, 1])) for pose in poses)
    turns = ";".join(_degrees(float(pose.headings[i])) for pose in poses)
    inner = f'<use href="#{prefix}{i}"/>'
    if i == (hinge - 1) % len(drawn):
        inner += dot(Dot(drawn.pieces[i].length, 0.0, "open"), pen)
    start = dot(Dot(0.0, 0.0, "open" if i == hinge else "hinge"), pen)
    return f"<g>{_animation('translate', moves)}<g>{_animation('rotate', turns)}{inner}</g>{start}</g>"


def _animation(kind: str, values: str) -> str:
    return (
        f'<animateTransform attributeName="transform" type="{kind}" dur="{SECONDS:g}s" '
        f'repeatCount="indefinite" values="{values}"/>'
    )


def _degrees(heading: float) -> str:
    # Not reduced to one turn: key frames must not jump from 180 to -180.
    return f"{round(-math.degrees(heading), 1) + 0.0:g}"

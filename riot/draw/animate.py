"""The motion as an animated SVG: SMIL only, so that it moves wherever SVG is shown, without script. Ours."""

from __future__ import annotations

import math
from dataclasses import dataclass

from riot.draw.keyframes import (
    Keyframes,
    eased,
    frame_count,
    hinge_dot,
    keyframes,
    loop_seconds,
    motion_marks,
    painting_order,
    swept_box,
)
from riot.draw.panels import sketch
from riot.draw.piece_image import NO_IMAGES, PieceImages
from riot.draw.scene import Dot, Scene
from riot.draw.svg import dot, naming, painted, piece_id, whole
from riot.draw.svg_text import translation
from riot.draw.tuning import MOTION_PENS, PAUSE_FRAMES, STILL_TIME, SWEPT_MARGIN
from riot.motion.planner import motion_of
from riot.transform.motion import Motion
from riot.transform.transform import Transform

MOTION_STYLE = (
    ".r-still{display:none}@media (prefers-reduced-motion:reduce){.r-still{display:inline}.r-move{display:none}}"
)
"""Rules that show the still pose instead of the animation."""


@dataclass(frozen=True, eq=False)
class Swing:
    """A scene (the still pose, in a box that every pose fits) and the SVG body of the animation within it."""

    scene: Scene
    body: str


def animate_svg(transform: Transform, images: PieceImages = NO_IMAGES) -> str:
    """The motion from P to Q and back, as a whole animated SVG file of deterministic text.

    It is `Transform.motion`, planned now if it was not: no two pieces of a plane meet. Every piece has key frames of
    translation and rotation, eased at both ends; hinges are dots, larger where they lift, the ends of the open hinge
    rings. With ``images`` the pieces show their front.

    Examples
    --------
    >>> from riot.groundtruth.pairs import dudeney, exact_transform
    >>> animate_svg(exact_transform(dudeney())).count("<animateTransform")  # a move and a turn of each of four pieces
    8
    """
    prefix = naming(sketch(transform).pieces, images)
    swing = swing_of(transform, prefix, images)
    return whole(swing.scene, swing.body, prefix, style=MOTION_STYLE)


def swing_of(transform: Transform, prefix: str, images: PieceImages = NO_IMAGES) -> Swing:
    """The animation, for pieces defined under ``prefix`` (see `riot.draw.svg.definitions`)."""
    drawn, motion = sketch(transform), motion_of(transform)
    frames = frame_count(motion)
    there = keyframes(motion, eased(frames))
    box = swept_box(drawn, there, margin=SWEPT_MARGIN)
    pen = (box[2] - box[0]) / MOTION_PENS
    names = transform.p.name or "P", transform.q.name or "Q"
    title = f"{len(drawn)} hinged pieces swing from {names[0]} to {names[1]} and back: the chain {motion.words}"
    scene = Scene(title, box, pen, drawn.pieces, tuple(motion_marks(drawn, motion, STILL_TIME)), images)
    uses = [f'<use href="#{piece_id(prefix, i, images=images)}"/>' for i in range(len(drawn))]
    moving = "".join(_piece(drawn, i, there, uses[i], pen, motion) for i in painting_order(motion))
    body = f'<g class="r-move">{moving}</g><g class="r-still">{painted(scene, prefix)}</g>'
    return Swing(scene, body)


def _piece(drawn: Transform, i: int, there: Keyframes, use: str, pen: float, motion: Motion) -> str:
    moves = _loop([translation(x, y) for x, y in there.origins[:, i].tolist()])
    turns = _loop([_degrees(heading) for heading in there.headings[:, i].tolist()])
    seconds = loop_seconds(len(there.headings) - 1)
    inner = use
    if i == (motion.open_hinge - 1) % len(drawn):
        inner += dot(Dot(drawn.pieces[i].length, 0.0, "open"), pen)
    start = dot(hinge_dot(motion, i, 0.0, 0.0), pen)
    return (
        f"<g>{_animation('translate', moves, seconds)}<g>{_animation('rotate', turns, seconds)}{inner}</g>{start}</g>"
    )


def _loop(there: list[str]) -> str:
    """The key frames of the way there, a pause, the way back, and a pause around the start."""
    rest = there[:1] * (PAUSE_FRAMES // 2)
    return ";".join([*rest, *there, *there[-1:] * PAUSE_FRAMES, *there[-2:0:-1], *rest])


def loop_times(transform: Transform) -> dict[str, float]:
    """When the loop of `swing_of` leaves P (``start``), reaches Q (``end``) and is over (``duration``), in seconds.

    ``mirror`` less a time is the time on the way back at which the pieces lie as at that time.

    >>> times = loop_times(transform)
    >>> 0.0 < times["start"] < times["end"] < times["duration"] / 2 < times["mirror"] / 2
    True
    """
    frames = frame_count(motion_of(transform))
    duration = loop_seconds(frames)
    rest = PAUSE_FRAMES // 2
    step = duration / (len(_loop([""] * (frames + 1)).split(";")) - 1)
    return {
        "start": rest * step,
        "end": (rest + frames) * step,
        "mirror": 2 * (rest + frames + rest) * step,
        "duration": duration,
    }


def _animation(kind: str, values: str, seconds: float) -> str:
    return (
        f'<animateTransform attributeName="transform" type="{kind}" dur="{seconds:.4g}s" '
        f'repeatCount="indefinite" values="{values}"/>'
    )


def _degrees(heading: float) -> str:
    # Not reduced to one turn: key frames must not jump from 180 to -180.
    return f"{round(-math.degrees(heading), 1) + 0.0:g}"

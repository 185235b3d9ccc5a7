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
from riot.draw.panels import shown_from_back, sketch
from riot.draw.piece_image import NO_IMAGES, PieceImages
from riot.draw.scene import Dot, Scene, extent
from riot.draw.svg import dot, naming, painted, piece_id, whole
from riot.draw.svg_text import translation
from riot.draw.tuning import MOTION_PENS, PAUSE_FRAMES, STILL_TIME, SWEPT_MARGIN, TURN_FRAMES
from riot.motion.planner import motion_of
from riot.transform.motion import Motion
from riot.transform.transform import Transform

MOTION_STYLE = (
    ".r-still{display:none}@media (prefers-reduced-motion:reduce){.r-still{display:inline}.r-move{display:none}}"
)
"""Rules that show the still pose instead of the animation."""


_REST = PAUSE_FRAMES // 2
"""Frames of the pause as P, at either end of the loop."""


@dataclass(frozen=True, eq=False)
class Swing:
    """A scene (the still pose, in a box that every pose fits) and the SVG body of the animation within it."""

    scene: Scene
    body: str


def animate_svg(transform: Transform, images: PieceImages = NO_IMAGES) -> str:
    """The motion from P to Q and back, as a whole animated SVG file of deterministic text.

    It is `Transform.motion`, planned now if it was not: no two pieces of a plane meet. Every piece has key frames of
    translation and rotation, eased at both ends; hinges are dots, larger where they lift, the ends of the open hinge
    rings. With ``images`` the pieces show their front. If the hand sees Q on the back, the puzzle is turned over at the
    end (`riot.draw.panels.shown_from_back`).

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
    loop = Loop(frames, shown_from_back(transform, images))
    uses = [_faces(prefix, i, images, loop) for i in range(len(drawn))]
    moving = "".join(_piece(drawn, i, there, uses[i], pen, motion, loop) for i in painting_order(motion))
    if loop.turn:
        left, _, right, _ = extent(motion_marks(drawn, motion, 1.0), drawn.pieces)
        moving = _turned_over(moving, 0.5 * (left + right), loop)
    body = f'<g class="r-move">{moving}</g><g class="r-still">{painted(scene, prefix)}</g>'
    return Swing(scene, body)


@dataclass(frozen=True)
class Loop:
    """The steps of one loop: a pause around the start, ``frames`` to Q, a pause there, as many back.

    ``turns``: the puzzle is turned over before the pause, and back after it, in `turn` frames each.
    """

    frames: int
    turns: bool

    @property
    def turn(self) -> int:
        """Frames in which the puzzle is turned over."""
        return TURN_FRAMES if self.turns else 0

    @property
    def seconds(self) -> float:
        """Duration."""
        return loop_seconds(self.frames + self.turn)

    @property
    def steps(self) -> int:
        """Steps between its key frames."""
        return 2 * (self.frames + self.turn) + PAUSE_FRAMES + 2 * _REST - 1

    def values(self, there: list[str], turn: list[str] | None = None) -> str:
        """A value for every key frame: on the way there, while it is turned over (as at the end, without), and back."""
        turn = turn or there[-1:] * self.turn
        over = [*there[-1:], *turn]
        held = [*turn, *over[-1:] * PAUSE_FRAMES, *over[-2::-1]]
        return ";".join([*there[:1] * _REST, *there, *held, *there[-2:0:-1], *there[:1] * _REST])


def _turned_over(moving: str, middle: float, loop: Loop) -> str:
    """All pieces, mirrored about an upright line at the end."""
    there = ["1 1"] * (loop.frames + 1)
    turn = [f"{round(math.cos(math.pi * share), 4) + 0.0:g} 1" for share in eased(loop.turn)[1:].tolist()]
    scale = _animation("scale", loop.values(there, turn), loop.seconds)
    return (
        f'<g transform="translate({translation(middle, 0.0)})"><g>{scale}'
        f'<g transform="translate({translation(-middle, 0.0)})">{moving}</g></g></g>'
    )


def _faces(prefix: str, piece: int, images: PieceImages, loop: Loop) -> str:
    """What shows of a piece: its front, and its back while that is up, if it looks otherwise."""
    front, back = (f'<use href="#{piece_id(prefix, piece, side, images)}"' for side in ("p", "q"))
    if not loop.turn or front == back:
        return f"{front}/>"
    edge_on = _REST + loop.frames + 0.5 * loop.turn
    begin, end = edge_on / loop.steps, (edge_on + loop.turn + PAUSE_FRAMES) / loop.steps
    times = f'keyTimes="0;{begin:.5f};{end:.5f}" dur="{loop.seconds:.4g}s" repeatCount="indefinite"'
    shown = '<animate attributeName="visibility" calcMode="discrete" values="{};{};{}" ' + f"{times}/></use>"
    return (
        f"{front}>{shown.format('visible', 'hidden', 'visible')}"
        f'{back} visibility="hidden">{shown.format("hidden", "visible", "hidden")}'
    )


def _piece(drawn: Transform, i: int, there: Keyframes, use: str, pen: float, motion: Motion, loop: Loop) -> str:
    moves = loop.values([translation(x, y) for x, y in there.origins[:, i].tolist()])
    turns = loop.values([_degrees(heading) for heading in there.headings[:, i].tolist()])
    seconds, inner = loop.seconds, use
    if i == (motion.open_hinge - 1) % len(drawn):
        inner += dot(Dot(drawn.pieces[i].length, 0.0, "open"), pen)
    start = dot(hinge_dot(motion, i, 0.0, 0.0), pen)
    return (
        f"<g>{_animation('translate', moves, seconds)}<g>{_animation('rotate', turns, seconds)}{inner}</g>{start}</g>"
    )


def loop_times(transform: Transform, images: PieceImages = NO_IMAGES) -> dict[str, float]:
    """When the loop of `swing_of` leaves P (``start``), is Q (``end``) and is over (``duration``), in seconds.

    At the end Q is turned over, if it is. ``mirror`` less a time is the time on the way back at which the pieces lie as
    at that time.

    >>> times = loop_times(transform)
    >>> 0.0 < times["start"] < times["end"] < times["duration"] / 2 < times["mirror"] / 2
    True
    """
    loop = Loop(frame_count(motion_of(transform)), shown_from_back(transform, images))
    step, there = loop.seconds / loop.steps, _REST + loop.frames + loop.turn
    return {
        "start": _REST * step,
        "end": there * step,
        "mirror": (2 * there + PAUSE_FRAMES) * step,
        "duration": loop.seconds,
    }


def _animation(kind: str, values: str, seconds: float) -> str:
    return (
        f'<animateTransform attributeName="transform" type="{kind}" dur="{seconds:.4g}s" '
        f'repeatCount="indefinite" values="{values}"/>'
    )


def _degrees(heading: float) -> str:
    # Not reduced to one turn: key frames must not jump from 180 to -180.
    return f"{round(-math.degrees(heading), 1) + 0.0:g}"

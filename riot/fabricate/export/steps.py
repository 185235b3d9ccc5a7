"""The steps of putting a puzzle together, a picture each, as those of a construction kit. Ours."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from itertools import pairwise
from typing import TYPE_CHECKING

import shapely

from riot.draw.scene import Bitmap, Mark, Scene, moved
from riot.fabricate.export.instructions import IN_PLACE_STEPS, PIN_STEPS, magnet_steps, pins_in_words, shape_names
from riot.fabricate.export.joint_picture import joint_view
from riot.fabricate.export.magnet_picture import magnet_marks
from riot.fabricate.export.page import HEIGHT, PAGE_MARGIN_MM, WIDTH
from riot.fabricate.export.paper import Frame, region_mark, sheet, text
from riot.fabricate.export.poses import chain, closed, drawn, fit, frames_of
from riot.fabricate.export.tray_sheet import tray_marks

if TYPE_CHECKING:
    from riot.draw.solid import View
    from riot.draw.texture.names import Side
    from riot.fabricate.model import Design
    from riot.fabricate.solid import Part

COVER_MM = 100.0
"""Greatest height of a picture on the front page."""

COLUMNS, ROWS = 2, 3
"""Of steps on a page."""

_HEAD_MM, _NUMBER_MM, _WORDS_MM, _LETTERS = 12.0, 9.0, 20.0, 44


def cover(design: Design, views: Mapping[Side, View]) -> Scene:
    """The front page: ``views`` of the finished puzzle as both shapes, and what is in the bag."""
    names, middle = shape_names(design), 0.5 * WIDTH
    marks: list[Mark] = [
        text(middle, HEIGHT - 32.0, f"{names[0]} ⇄ {names[1]}", 11.0, anchor="middle", weight="bold"),
        text(middle, HEIGHT - 41.0, "a puzzle that turns inside out", 5.0, "note", "middle"),
    ]
    top = HEIGHT - 50.0
    sides: tuple[Side, Side] = ("p", "q")
    for side, name in zip(sides, names, strict=True):
        view = views[side]
        scale = min((WIDTH - 4 * PAGE_MARGIN_MM) / view.width, (COVER_MM - 10.0) / view.height)
        wide, high = 0.5 * scale * view.width, scale * view.height
        base = top - 0.5 * (COVER_MM - 10.0) - 0.5 * high
        marks.append(Bitmap(view.pixels, (middle - wide, base, middle + wide, base + high)))
        marks.append(text(middle, top - COVER_MM + 4.0, name, 5.0, anchor="middle", weight="bold"))
        top -= COVER_MM + 6.0
    bag = f"{len(design.pieces)} pieces, {pins_in_words(design)}"
    marks.append(text(middle, PAGE_MARGIN_MM + 4.0, bag, 4.0, "note", "middle"))
    return sheet("front page", WIDTH, HEIGHT, marks)


def step_pages(design: Design, trays: tuple[Part, ...] = ()) -> list[Scene]:
    """The pages of steps: lay the pieces out, join them one after another, swing them shut either way, put them into
    their trays."""
    names, n, first = shape_names(design), len(design.pieces), design.motion.open_hinge
    order = [(first + k) % n for k in range(n)]
    wide = (WIDTH - 2 * PAGE_MARGIN_MM - 10.0 * (COLUMNS - 1)) / COLUMNS
    tall = (HEIGHT - 2 * PAGE_MARGIN_MM - _HEAD_MM) / ROWS
    room = wide, tall - _NUMBER_MM - _WORDS_MM - 8.0

    numbers = ", ".join(str(i + 1) for i in order)
    glued = [(magnet_marks(design, (room[0] - 6.0, room[1])), words) for words in magnet_steps(design)]
    if design.placement is None:
        steps = [(_whole(design, chain(design), room), f"Lay the pieces in a row, fronts up: {numbers}."), *glued]
        steps += [(_joined(design, before, after, room), _words(design, after)) for before, after in pairwise(order)]
    else:
        printed = frames_of(design, design.motion.pose_at(design.placement.time))
        frames = (printed, chain(design))
        steps = [(_whole(design, pose, room), words) for pose, words in zip(frames, IN_PLACE_STEPS, strict=True)]
        steps += glued
    shut = [_whole(design, closed(design, t), room) for t in (0.0, 1.0)]
    turned = " Turn it over." if design.transform.mirrored_q else ""
    steps.append((shut[0], f"Swing the row shut one way: {names[0]}!"))
    steps.append((shut[1], f"Open it, and swing it shut the other way: {names[1]}!{turned}"))
    for tray, name in zip(trays, names, strict=False):
        picture = tray_marks(design, tray, (room[0] - 6.0, room[1]))
        steps.append((picture, f"{tray.name} keeps it as {name}; take it out by its rim."))

    pages: list[list[Mark]] = []
    for number, (picture, words) in enumerate(steps):
        place = number % (ROWS * COLUMNS)
        if place == 0:
            heading = text(PAGE_MARGIN_MM, HEIGHT - PAGE_MARGIN_MM - 5.0, "Put it together", 6.0, weight="bold")
            pages.append([heading])
        row, column = divmod(place, COLUMNS)
        left = PAGE_MARGIN_MM + column * (wide + 10.0)
        top = HEIGHT - PAGE_MARGIN_MM - _HEAD_MM - row * tall
        pages[-1] += moved(picture, left + 0.5 * wide, top - _NUMBER_MM - 2.0 - 0.5 * room[1])
        pages[-1].append(region_mark(shapely.box(left, top - tall + 4.0, left + wide, top), "rule"))
        pages[-1].append(text(left + 3.0, top - 8.0, str(number + 1), 7.0, weight="bold"))
        for k, line in enumerate(textwrap.wrap(words, _LETTERS)):
            pages[-1].append(text(left + 3.0, top - tall + _WORDS_MM - 1.0 - 4.6 * k, line, 3.4))
    return [sheet("steps", WIDTH, HEIGHT, marks) for marks in pages]


def _whole(design: Design, frames: list[Frame], room: tuple[float, float]) -> list[Mark]:
    """All pieces in a pose, about the origin."""
    return drawn(design, frames, fit(frames, design, room[0] - 6.0, room[1]), 0.0, 0.0, numbers=True, hinges=True)


def _words(design: Design, after: int) -> str:
    """How piece ``after`` is joined to the one before it."""
    before, kind = (after - 1) % len(design.pieces), design.pieces[after].start.kind
    if kind == "telescopic":
        return (
            f"Push a sleeve into the barrel of {before + 1} from below, then the rod of {after + 1} into the sleeve "
            "from above, until both snap."
        )
    upper, lower = (after, before) if design.pieces[after].start.role == "upper" else (before, after)
    return f"Lay the knuckle of {upper + 1} on that of {lower + 1}. {PIN_STEPS[design.pins[0].kind]}"


def _joined(design: Design, before: int, after: int, room: tuple[float, float]) -> list[Mark]:
    """Two pieces, one over the other, and what joins them, about the origin."""
    view = joint_view(design, before, after)
    scale = min(1.0, (room[0] - 6.0) / view.width, room[1] / view.height)
    wide, high = 0.5 * scale * view.width, 0.5 * scale * view.height
    return [Bitmap(view.pixels, (-wide, -high, wide, high))]

"""One transform of the gallery: its row and its pictures, in which a piece has one colour. Ours."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from pipeline.report.rows import TransformRow
from riot.draw.animate import loop_times, swing_of
from riot.draw.panels import chain_marks, deformation_marks, dissection_marks, input_marks, sketch
from riot.draw.piece_image import NO_IMAGES, PieceImages
from riot.draw.scene import Box, Mark, Scene, around, extent
from riot.draw.svg import definitions, fragment, naming
from riot.errors import needs_extra
from riot.motion.planner import motion_of
from riot.transform.transform import Transform

with needs_extra("mine"):
    from markupsafe import Markup

PANEL_PENS, CHAIN_PENS = 210.0, 420.0
"""Usual widths of the pictures on the page, in pixels: dots are sized for them."""

MARGIN = 0.06
"""Around the marks, in units of the shape."""


VIEWS: tuple[tuple[Callable[[Transform, str], list[Mark]], str], ...] = (
    (input_marks, "{} and its trunk"),
    (deformation_marks, "result over input"),
    (dissection_marks, "dissection"),
)
"""The pictures of each side, and their captions."""


@dataclass(frozen=True)
class CardPicture:
    """An SVG element for a page that has the definitions of its pieces, and a caption."""

    svg: Markup
    caption: str = ""


@dataclass(frozen=True)
class Player:
    """The swing as an SVG element, and when it leaves P, reaches Q, is back, and starts again, in seconds.

    See `riot.draw.animate.loop_times`.
    """

    svg: Markup
    times: Mapping[str, float]


@dataclass(frozen=True)
class Card:
    """A transform as its page shows it.

    ``definitions`` of its pieces stand once on the page; ``player`` is None unless a motion is planned; ``panels`` are
    the pictures of P, then those of Q; ``chain`` is laid straight.
    """

    row: TransformRow
    definitions: Markup
    player: Player | None
    panels: tuple[CardPicture, ...]
    chain: CardPicture


def card(row: TransformRow, transform: Transform, images: PieceImages = NO_IMAGES) -> Card:
    """The card of a row of `transforms` and its ``.riot`` file, with the images of its pieces."""
    sketched = sketch(transform)
    pieces, prefix = sketched.pieces, naming(sketched.pieces, images)
    sides = (("p", row.name_p), ("q", row.name_q))
    marks = {side: [view(sketched, side) for view, _ in VIEWS] for side, _ in sides}
    frames = _frames(sketched, marks)

    def drawn(title: str, box: Box, pens: float, shown: list[Mark], kind: str = "") -> Markup:
        scene = Scene(title, box, (box[2] - box[0]) / pens, (), tuple(shown), images)
        return Markup(fragment(scene, prefix, kind=kind))

    panels = [
        CardPicture(drawn(f"{name}: {(words := caption.format(side.upper()))}", frames[side], PANEL_PENS, view), words)
        for side, name in sides
        for (_, caption), view in zip(VIEWS, marks[side], strict=True)
    ]
    # Pieces of an approximate transform overlap already when it is closed: no way to swing them is free.
    motion = None if row.approximate else motion_of(transform)
    player = None
    if motion is not None:
        swing = swing_of(transform, prefix, images)
        player = Player(Markup(fragment(swing.scene, prefix, swing.body, "swing")), loop_times(transform, images))
    chain = chain_marks(sketched, 0 if motion is None else motion.open_hinge)
    title = f"The chain of {len(sketched)} pieces laid straight: {row.name_p} below, {row.name_q} above"
    box = around([extent(chain, pieces)], MARGIN)
    straight = CardPicture(drawn(title, box, CHAIN_PENS, chain, "chain"), "the chain, straight")
    return Card(row, Markup(definitions(pieces, prefix, images)), player, tuple(panels), straight)


def _frames(sketched: Transform, marks: dict[str, list[list[Mark]]]) -> dict[str, Box]:
    """A box for each side's pictures; both of one size, so that both shapes are seen at one scale."""
    boxes = {side: around([extent(view, sketched.pieces) for view in views], MARGIN) for side, views in marks.items()}
    wide = max(x1 - x0 for x0, _, x1, _ in boxes.values()) / 2
    high = max(y1 - y0 for _, y0, _, y1 in boxes.values()) / 2
    middles = {side: ((x0 + x1) / 2, (y0 + y1) / 2) for side, (x0, y0, x1, y1) in boxes.items()}
    return {side: (x - wide, y - high, x + wide, y + high) for side, (x, y) in middles.items()}

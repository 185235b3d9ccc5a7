"""One transform of the gallery: its pictures, all in the same colours, and its numbers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from pipeline.report.markup import degrees, facts, number, small
from pipeline.report.rows import TransformRow
from riot.draw.animate import swing_of
from riot.draw.panels import chain_marks, deformation_marks, dissection_marks, input_marks, sketch
from riot.draw.piece_image import NO_IMAGES, PieceImages
from riot.draw.scene import Box, Mark, PlacedPiece, Scene, around, extent
from riot.draw.svg import definitions, escape, fragment, naming
from riot.motion.planner import motion_of
from riot.transform.transform import Transform

PANEL_PENS, CHAIN_PENS, THUMB_PENS = 210.0, 420.0, 96.0
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
class Card:
    """HTML of one transform: definitions of its pieces (once a page), its names and worth, pictures, and numbers."""

    row: TransformRow
    definitions: str
    names: str
    worth: str
    content: str
    thumb: str
    """A small picture for a page that has the definitions."""

    @property
    def body(self) -> str:
        """The card as an element of a page of many."""
        rank = self.row.rank
        return (
            f'<article class="card" id="t{rank}" aria-labelledby="h{rank}">'
            f'<header><span class="rank">{rank}</span><h3 id="h{rank}">{self.names}</h3>{self.worth}</header>'
            f"{self.content}</article>\n"
        )


def card(row: TransformRow, transform: Transform, skins: PieceImages = NO_IMAGES) -> Card:
    """The card of a row of `transforms` and its ``.riot`` file, with the skins of its pieces."""
    drawn = sketch(transform)
    prefix = naming(drawn.pieces, skins)
    sides = (("p", row.name_p), ("q", row.name_q))
    marks = {side: [view(drawn, side) for view, _ in VIEWS] for side, _ in sides}
    frames = _frames(drawn, marks)
    figures = "".join(
        _figure(
            Scene(
                f"{name}: {words.format(side.upper())}",
                frames[side],
                _pen(frames[side], PANEL_PENS),
                (),
                tuple(found),
                skins,
            ),
            prefix,
            words.format(side.upper()),
        )
        for side, name in sides
        for (_, words), found in zip(VIEWS, marks[side], strict=True)
    )
    # Pieces of an approximate transform overlap already when it is closed: no way to swing them is free.
    motion = None if row.approximate else motion_of(transform)
    chain = tuple(chain_marks(drawn, 0 if motion is None else motion.open_hinge))
    box = around([extent(chain, drawn.pieces)], MARGIN)
    straight = Scene(
        f"The chain of {len(drawn)} pieces laid straight: {row.name_p} below, {row.name_q} above",
        box, _pen(box, CHAIN_PENS), (), chain, skins,
    )  # fmt: skip
    moves = "" if motion is None else _moves(transform, prefix, motion.words, skins)
    worth = f'<p class="worth">{"approximate, " if row.approximate else ""}IoU <b>{number(row.iou)}</b></p>'
    content = (
        f'<div class="pictures"><div class="panels">{figures}</div><div class="moves">'
        f"{moves}{_figure(straight, prefix, 'the chain, straight', 'chain')}</div></div>{_numbers(row)}"
    )
    thumb = _thumb(row, drawn, prefix, frames, skins)
    return Card(row, definitions(drawn.pieces, prefix, skins), _names(row), worth, content, thumb)


def _moves(transform: Transform, prefix: str, words: str, skins: PieceImages) -> str:
    swing = swing_of(transform, prefix, skins)
    picture = fragment(swing.scene, prefix, swing.body, "swing")
    return f"<figure>{picture}<figcaption>the chain {escape(words)}</figcaption></figure>"


def _frames(drawn: Transform, marks: dict[str, list[list[Mark]]]) -> dict[str, Box]:
    """A box for each side's pictures; both of one size, so that both shapes are seen at one scale."""
    boxes = {side: around([extent(found, drawn.pieces) for found in views], MARGIN) for side, views in marks.items()}
    wide = max(x1 - x0 for x0, _, x1, _ in boxes.values()) / 2
    high = max(y1 - y0 for _, y0, _, y1 in boxes.values()) / 2
    middles = {side: ((x0 + x1) / 2, (y0 + y1) / 2) for side, (x0, y0, x1, y1) in boxes.items()}
    return {side: (x - wide, y - high, x + wide, y + high) for side, (x, y) in middles.items()}


def _figure(scene: Scene, prefix: str, caption: str, kind: str = "") -> str:
    return f"<figure>{fragment(scene, prefix, kind=kind)}<figcaption>{escape(caption)}</figcaption></figure>"


def _thumb(row: TransformRow, drawn: Transform, prefix: str, frames: dict[str, Box], skins: PieceImages) -> str:
    halves = []
    for side, name in (("p", row.name_p), ("q", row.name_q)):
        parts = tuple(mark for mark in dissection_marks(drawn, side) if isinstance(mark, PlacedPiece))
        scene = Scene(name, frames[side], _pen(frames[side], THUMB_PENS), (), parts, skins)
        halves.append(fragment(scene, prefix))
    said = f"{row.rank}: {row.name_p} and {row.name_q}, IoU {number(row.iou)}"
    return f'<a class="thumb" href="#t{row.rank}" title="{escape(said)}">{"".join(halves)}</a>'


def _names(row: TransformRow) -> str:
    sides = ((row.name_p, row.class_p), (row.name_q, row.class_q))
    said = [
        f'<span class="name">{escape(name)}</span>'
        + (f' <span class="class">{escape(kind)}</span>' if kind not in ("", name) else "")
        for name, kind in sides
    ]
    return ' <span class="arrow" aria-label="and">⇄</span> '.join(said)


def _numbers(row: TransformRow) -> str:
    def both(p: float, q: float, form: Callable[[float], str] = number) -> str:
        return f"{form(p)} <i>·</i> {form(q)}"

    return facts(
        [
            ("pieces", str(row.n)),
            ("QCRS <i>·</i> CRS", both(row.qcrs, row.crs)),
            (
                "edges · angles · area",
                f"{number(row.s_edge)} <i>·</i> {number(row.s_angle)} <i>·</i> {number(row.s_area)}",
            ),
            ("IoU P · Q", both(row.iou_p, row.iou_q)),
            ("its bound", both(row.bound_p, row.bound_q)),
            ("change / least", number(row.change_ratio)),
            ("Hausdorff / L<sub>c</sub>", both(row.hausdorff_p, row.hausdorff_q)),
            (
                "mean distance / L<sub>c</sub>",
                both(row.mean_distance_p, row.mean_distance_q, lambda value: number(value, 4)),
            ),
            ("bending / input’s", both(row.bending_p, row.bending_q, lambda value: number(value, 2))),
            ("directions off", both(row.direction_p, row.direction_q, degrees)),
            ("area residual", small(row.area_residual)),
            ("hinge residual", small(row.hinge_residual)),
        ]
    )


def _pen(box: Box, pens: float) -> float:
    return (box[2] - box[0]) / pens

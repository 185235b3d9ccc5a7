"""One figure of a transform: inputs and trunks, dissections, deformation, the chain, and the swing in seven poses."""

from __future__ import annotations

import os
from pathlib import Path

from riot.draw.files import write_scene
from riot.draw.keyframes import motion_marks
from riot.draw.panels import chain_marks, deformation_marks, dissection_marks, input_marks, shown_from_back, sketch
from riot.draw.piece_image import NO_IMAGES, PieceImages
from riot.draw.scene import Box, Label, Mark, Scene, extent, mirrored, moved
from riot.draw.tuning import CAPTION_LENGTH, FIGURE_PENS, FIGURE_TIMES
from riot.motion.planner import motion_of
from riot.transform.certificate import certify
from riot.transform.deformation import measure_deformation
from riot.transform.transform import Transform


def draw_transform(transform: Transform, path: str | os.PathLike[str], images: PieceImages = NO_IMAGES) -> None:
    """Write one figure of the transform; the suffix (svg, png, pdf) chooses the format.

    With ``images`` the dissections of P and Q show their own side of the pieces; chain and swing show the front, P's.
    What the hand sees on the back (`riot.draw.panels.shown_from_back`) is drawn as it is seen there.
    The same transform gives the same bytes. Raises `riot.draw.files.PictureFormatError` (a ValueError) for another
    suffix, and OSError if the file cannot be written. Ours.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from riot.groundtruth.pairs import dudeney, exact_transform
    >>> with TemporaryDirectory() as folder:
    ...     draw_transform(exact_transform(dudeney()), Path(folder) / "dudeney.svg")
    ...     (Path(folder) / "dudeney.svg").read_text()[:4]
    '<svg'
    """
    write_scene(Path(path), lambda: figure_scene(transform, images))


def figure_scene(transform: Transform, images: PieceImages = NO_IMAGES) -> Scene:
    """The figure of `draw_transform` before it has a format.

    >>> len(figure_scene(transform).pieces)
    4
    """
    drawn = sketch(transform)
    motion = motion_of(transform)
    names = _short(transform.p.name or "P"), _short(transform.q.name or "Q")
    cells, back = [_row(drawn, side) for side in ("p", "q")], shown_from_back(drawn, images)
    if back:
        cells[1] = [mirrored(cell) for cell in cells[1]]
    boxes = [extent(marks, drawn.pieces) for row in cells for marks in row]
    cell_width = max(x1 - x0 for x0, _, x1, _ in boxes)
    gap = 0.14 * cell_width
    width = 3 * cell_width + 4 * gap
    pen = width / FIGURE_PENS
    line = 30 * pen

    marks: list[Mark] = []
    top = -46 * pen
    marks.append(Label(gap, top, f"{names[0]} ⇄ {names[1]}", size=24, anchor="start", weight="bold"))
    marks.append(Label(gap, top - 24 * pen, _numbers(transform), "note", anchor="start"))
    top -= 24 * pen + line
    for row, name, seen in zip(cells, names, ("", ", from the back" if back else ""), strict=True):
        captions = (*_captions(drawn, name), f"{name} from {len(drawn)} pieces{seen}")
        tall = max(y1 - y0 for _, y0, _, y1 in (extent(cell, drawn.pieces) for cell in row))
        for column, (cell, caption) in enumerate(zip(row, captions, strict=True)):
            x = gap + cell_width / 2 + column * (cell_width + gap)
            marks += _centred(cell, drawn, x, top - tall / 2)
            marks.append(Label(x, top - tall - 0.9 * line, caption, "note"))
        top -= tall + 2 * line
    chain = chain_marks(drawn, motion.open_hinge)
    top = _fitted(marks, [chain], drawn, top, width - 2 * gap, gap)
    marks.append(Label(width / 2, top - 0.9 * line, f"the chain: {names[0]} below, {names[1]} above", "note"))
    top -= 2 * line
    poses = [motion_marks(drawn, motion, t) for t in FIGURE_TIMES]
    if back:
        poses.append(cells[1][2])
    top = _fitted(marks, poses, drawn, top, width - 2 * gap, gap)
    turned = ", and is turned over" if back else ""
    words = f"the chain, open at one hinge, {motion.words}{turned}"
    marks.append(Label(width / 2, top - 0.9 * line, words, "note"))
    title = f"Reversible transform of {names[0]} into {names[1]}, {len(drawn)} hinged pieces"
    return Scene(title, (0.0, top - 2 * line, width, 0.0), pen, drawn.pieces, tuple(marks), images)


def _short(name: str) -> str:
    return name if len(name) <= CAPTION_LENGTH else f"{name[: CAPTION_LENGTH - 1]}…"


def _captions(drawn: Transform, name: str) -> tuple[str, str]:
    if drawn.bend_p is None and drawn.bend_q is None:
        return f"{name} and its trunk", "what the pieces make, over it"
    return f"{name}, bent (thin line), and its trunk", "what the pieces make, over both"


def _row(drawn: Transform, side: str) -> list[list[Mark]]:
    return [input_marks(drawn, side), deformation_marks(drawn, side), dissection_marks(drawn, side)]


def _numbers(transform: Transform) -> str:
    deformation, certificate = measure_deformation(transform), certify(transform)
    verdict = (
        f"certified, residual {certificate.residual:.0e}"
        if certificate.passed
        else f"not certified: {certificate.failure.split('; ')[0]}"  # the first is enough for a heading
    )
    strain = f" · strain {deformation.rms_strain_p:.1%} and {deformation.rms_strain_q:.1%}" if deformation.bent else ""
    return f"{len(transform)} pieces · IoU {deformation.iou_p:.3f} and {deformation.iou_q:.3f}{strain} · {verdict}"


def _centred(marks: list[Mark], drawn: Transform, x: float, y: float) -> list[Mark]:
    x0, y0, x1, y1 = extent(marks, drawn.pieces)
    return moved(marks, x - (x0 + x1) / 2, y - (y0 + y1) / 2)


def _fitted(
    marks: list[Mark], groups: list[list[Mark]], drawn: Transform, top: float, width: float, left: float
) -> float:
    """Append groups side by side at one scale, at most 1, that fits the width; return their lower end."""
    boxes: list[Box] = [extent(group, drawn.pieces) for group in groups]
    space = 0.03 * width
    widths = [x1 - x0 for x0, _, x1, _ in boxes]
    scale = min(1.0, (width - space * (len(groups) - 1)) / sum(widths))
    tall = max(y1 - y0 for _, y0, _, y1 in boxes) * scale
    x = left + (width - scale * sum(widths) - space * (len(groups) - 1)) / 2
    for group, (x0, y0, _, y1), wide in zip(groups, boxes, widths, strict=True):
        marks += moved(group, x - scale * x0, top - tall / 2 - scale * (y0 + y1) / 2, scale)
        x += scale * wide + space
    return top - tall

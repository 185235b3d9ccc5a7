"""A still strip of the motion, P on the left and Q on the right, as in the paper's figures. Ours."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from riot.draw.files import write_scene
from riot.draw.keyframes import motion_marks
from riot.draw.panels import dissection_marks, ghost_marks, shown_from_back, sketch
from riot.draw.piece_image import NO_IMAGES, PieceImages
from riot.draw.scene import Label, Mark, Scene, extent, mirrored, moved
from riot.draw.tuning import CAPTION_LENGTH, STRIP_PENS, STRIP_POSES
from riot.motion.planner import motion_of
from riot.transform.transform import Transform


def draw_strip(transform: Transform, path: str | os.PathLike[str], images: PieceImages = NO_IMAGES) -> None:
    """Write the strip; the suffix (svg, png, pdf) chooses the format. With ``images`` the pieces show their front.

    The same transform gives the same bytes. Raises `riot.draw.files.PictureFormatError` (a ValueError) for another
    suffix, and OSError if the file cannot be written.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from riot.groundtruth.pairs import dudeney, exact_transform
    >>> with TemporaryDirectory() as folder:
    ...     draw_strip(exact_transform(dudeney()), Path(folder) / "dudeney.pdf")
    ...     (Path(folder) / "dudeney.pdf").read_bytes()[:8]
    b'%PDF-1.4'
    """
    write_scene(Path(path), lambda: strip_scene(transform, images=images))


def strip_scene(transform: Transform, poses: int = STRIP_POSES, images: PieceImages = NO_IMAGES) -> Scene:
    """``poses`` ≥ 2 poses at even times of `Transform.motion`, all at one scale, and what the motion needs in words.

    Behind the first and the last pose lie inputs that were bent first, as they were given. If the hand sees Q on the
    back (`riot.draw.panels.shown_from_back`), one more shows it there.

    >>> len(strip_scene(transform, 3).pieces)
    4
    """
    drawn, motion = sketch(transform), motion_of(transform)
    groups = [motion_marks(drawn, motion, float(t)) for t in np.linspace(0.0, 1.0, poses)]
    back = shown_from_back(drawn, images)
    groups[0], groups[-1] = [*ghost_marks(drawn, "p"), *groups[0]], [*ghost_marks(drawn, "q"), *groups[-1]]
    if back:
        groups.append(mirrored([*ghost_marks(drawn, "q"), *dissection_marks(drawn, "q")]))
    boxes = [extent(group, drawn.pieces) for group in groups]
    tall = max(y1 - y0 for _, y0, _, y1 in boxes)
    gap = 0.09 * tall
    width = sum(x1 - x0 for x0, _, x1, _ in boxes) + (len(groups) + 1) * gap
    pen = width / STRIP_PENS
    marks: list[Mark] = []
    x, middles = gap, []
    for group, (x0, y0, x1, y1) in zip(groups, boxes, strict=True):
        marks += moved(group, x - x0, -gap - tall / 2 - (y0 + y1) / 2)
        middles.append(x + (x1 - x0) / 2)
        x += x1 - x0 + gap
    names = [name[:CAPTION_LENGTH] for name in (transform.p.name or "P", transform.q.name or "Q")]
    base = -2.0 * gap - tall - 8 * pen
    marks.append(Label(middles[0], base, names[0]))
    marks.append(Label(middles[-1], base, names[1]))
    turned = ", and is turned over" if back else ""
    marks.append(Label(width / 2, base, f"{len(drawn)} pieces; the chain {motion.words}{turned}", "note"))
    title = f"{names[0]} swings into {names[1]}: {poses} poses of {len(drawn)} hinged pieces"
    return Scene(title, (0.0, base - 14 * pen, width, 0.0), pen, drawn.pieces, tuple(marks), images)

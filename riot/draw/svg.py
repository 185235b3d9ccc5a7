"""Scenes as SVG, written by hand: whole files, and fragments for a page that holds the style sheet once. Ours.

The text is deterministic: names of pieces come from their geometry.
"""

from __future__ import annotations

import base64
import hashlib
import io
import math
from collections.abc import Iterable, Mapping

import numpy as np
import numpy.typing as npt
from PIL import Image

from riot.draw.palette import LIGHT, hue
from riot.draw.piece_image import NO_IMAGES, PieceImage, PieceImages
from riot.draw.scene import Bitmap, Box, Dot, Label, Line, Mark, PlacedPiece, Region, Scene
from riot.draw.svg_style import file_style, number
from riot.draw.svg_text import UNITS, escape, path_data, rings_data, translation, turn, whole_number
from riot.transform.transform import Piece

JPEG_QUALITY = 88
"""Of images: a photograph is a tenth of what it is as PNG."""


def document(
    scene: Scene, width: int = 960, scheme: Mapping[str, str] = LIGHT, codec: str = "JPEG", background: bool = True
) -> str:
    """The scene as a whole SVG file, ``width`` pixels wide at its natural size, its textures as JPEG or PNG.

    Without ``background`` the page shows around the marks.

    >>> from riot.groundtruth.pairs import dudeney, exact_transform
    >>> from riot.draw.figure import figure_scene
    >>> document(figure_scene(exact_transform(dudeney())))[:4]
    '<svg'
    """
    prefix = naming(scene.pieces, scene.images)
    begin = opening(scene, prefix, width, scheme, codec=codec, background=background)
    return f"{begin}{painted(scene, prefix)}{CLOSING}"


def whole(
    scene: Scene,
    body: str,
    prefix: str,
    width: int = 960,
    scheme: Mapping[str, str] = LIGHT,
    style: str = "",
    background: bool = True,
) -> str:
    """An SVG file of a scene's frame, style and pieces around a body that is already SVG."""
    return f"{opening(scene, prefix, width, scheme, style, background=background)}{body}{CLOSING}"


CLOSING = "</svg>\n"
"""What ends an SVG file."""


def opening(
    scene: Scene,
    prefix: str,
    width: int = 960,
    scheme: Mapping[str, str] = LIGHT,
    style: str = "",
    codec: str = "JPEG",
    background: bool = True,
) -> str:
    """What an SVG file has before its body: all pictures of one box and the same pieces begin with the same text."""
    x0, y0, x1, y1 = scene.box
    height = round(width * (y1 - y0) / (x1 - x0))
    left, top, wide, high = _view(scene)
    paper = f'<rect x="{left}" y="{top}" width="{wide}" height="{high}" fill="{scheme["paper"]}"/>'
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{left} {top} {wide} {high}" width="{width}" '
        f'height="{height}" role="img"><title>{escape(scene.title)}</title>'
        f"<style>{file_style(scene.pen * UNITS, scheme)}{style}</style>"
        f"{paper if background else ''}{definitions(scene.pieces, prefix, scene.images, codec)}"
    )


def fragment(scene: Scene, prefix: str, body: str | None = None, kind: str = "") -> str:
    """The scene as an ``<svg>`` element for a page with `page_style` and, under ``prefix``, `definitions`.

    ``body`` replaces the scene's marks by SVG text; ``kind`` is a further class.
    """
    left, top, wide, high = _view(scene)
    inner = painted(scene, prefix) if body is None else body
    named = f"riot {kind}".strip()
    return (
        f'<svg class="{named}" viewBox="{left} {top} {wide} {high}" role="img">'
        f"<title>{escape(scene.title)}</title>{inner}</svg>"
    )


def naming(pieces: Iterable[Piece], images: PieceImages = NO_IMAGES) -> str:
    """A prefix for the pieces' ids that depends on their drawn geometry and their images alone."""
    state = hashlib.sha256("|".join(path_data(piece.polygon) for piece in pieces).encode())
    for side in sorted(images):
        for image in images[side]:
            state.update(f"|{side} {image.pixels.shape} {image.box}".encode() + image.pixels.tobytes())
    return f"r{state.hexdigest()[:8]}-"


def definitions(pieces: tuple[Piece, ...], prefix: str, images: PieceImages = NO_IMAGES, codec: str = "JPEG") -> str:
    """The ``<defs>`` of the pieces: each drawn once, with the seam along its trunk edge.

    Their ids are ``prefix0`` … in their colours, and ``prefixp0`` …, ``prefixq0`` … of the sides that have images.
    """
    groups = [
        f'<g id="{prefix}{i}"><path class="r-piece{hue(i, len(pieces))}" d="{path_data(piece.polygon)}"/>'
        f'<path class="r-seam" d="M0 0H{whole_number(piece.length)}"/></g>'
        for i, piece in enumerate(pieces)
    ]
    for side in sorted(images):
        groups += [
            _with_image(piece, f"{prefix}{side}{i}", image, codec)
            for i, (piece, image) in enumerate(zip(pieces, images[side], strict=True))
        ]
    return f"<defs>{''.join(groups)}</defs>" if groups else ""


def _with_image(piece: Piece, name: str, image: PieceImage, codec: str) -> str:
    """A piece with its image, cut to its outline."""
    path = path_data(piece.polygon)
    return f'<g id="{name}">{_image(image.pixels, image.box, path, name, codec)}<path class="r-cut" d="{path}"/></g>'


def _image(pixels: npt.NDArray[np.uint8], box: Box, clip: str, name: str, codec: str) -> str:
    """Pixels that fill a box, cut to the path ``clip`` if it is not empty, as JPEG or, without loss, as PNG."""
    x0, y0, x1, y1 = box
    clip_path = f'<clipPath id="{name}c"><path d="{clip}"/></clipPath>' if clip else ""
    cut = f' clip-path="url(#{name}c)"' if clip else ""
    return (
        f'{clip_path}<image{cut} x="{whole_number(x0)}" y="{whole_number(-y1)}" width="{whole_number(x1 - x0)}" '
        f'height="{whole_number(y1 - y0)}" preserveAspectRatio="none" href="{data_url(pixels, codec)}"/>'
    )


def data_url(pixels: npt.NDArray[np.uint8], codec: str) -> str:
    """Pixels (rows, columns, 3) as the address of an image, JPEG or, without loss, PNG.

    >>> data_url(np.zeros((1, 1, 3), np.uint8), "PNG")[:22]
    'data:image/png;base64,'
    """
    stream = io.BytesIO()
    options: dict[str, int] = {"quality": JPEG_QUALITY, "subsampling": 0} if codec == "JPEG" else {}
    Image.fromarray(pixels).save(stream, codec, **options)
    return f"data:image/{codec.lower()};base64,{base64.b64encode(stream.getvalue()).decode('ascii')}"


def piece_id(prefix: str, piece: int, side: str = "p", images: PieceImages = NO_IMAGES) -> str:
    """The id under which `definitions` has what shows of a piece.

    >>> piece_id("r1-", 3)
    'r1-3'
    """
    return f"{prefix}{side if side in images else ''}{piece}"


def painted(scene: Scene, prefix: str) -> str:
    """The scene's marks as SVG text."""
    return "".join(_mark(index, mark, prefix, scene) for index, mark in enumerate(scene.marks))


def _mark(index: int, mark: Mark, prefix: str, scene: Scene) -> str:
    if isinstance(mark, Region):
        return f'<path class="r-{mark.pen}" d="{rings_data(mark.rings)}"/>'
    if isinstance(mark, Line):
        return f'<path class="r-{mark.pen}" d="{path_data(mark.points, closed=False)}"/>'
    if isinstance(mark, PlacedPiece):
        scaled = "" if mark.scale == 1.0 else f"scale({number(mark.scale)})"
        if mark.mirror:
            scaled = f"scale(-{number(mark.scale)} {number(mark.scale)})"
        moves = f"translate({translation(mark.x, mark.y)})rotate({turn(mark.heading)}){scaled}"
        return f'<use href="#{piece_id(prefix, mark.piece, mark.side, scene.images)}" transform="{moves}"/>'
    if isinstance(mark, Bitmap):
        return _image(mark.pixels, mark.box, rings_data(mark.clip or ()), f"{prefix}b{index}", "PNG")
    if isinstance(mark, Dot):
        return dot(mark, scene.pen)
    return _label(mark, scene.pen)


def dot(mark: Dot, pen: float) -> str:
    """A dot as a ``<circle>``.

    >>> dot(Dot(0.5, 1.0, "hinge", 2.0), 0.01)
    '<circle class="r-hinge" cx="500" cy="-1000" r="20"/>'
    """
    centre = f'cx="{whole_number(mark.x)}" cy="{whole_number(-mark.y)}"'
    return f'<circle class="r-{mark.pen}" {centre} r="{whole_number(mark.radius * pen)}"/>'


def _label(mark: Label, pen: float) -> str:
    anchor = "" if mark.anchor == "start" else f' text-anchor="{mark.anchor}"'
    weight = "" if mark.weight == "normal" else f' font-weight="{mark.weight}"'
    where = f'x="{whole_number(mark.x)}" y="{whole_number(-mark.y)}" font-size="{whole_number(mark.size * pen)}"'
    return f'<text class="r-{mark.pen}" {where}{anchor}{weight}>{escape(mark.text)}</text>'


def _view(scene: Scene) -> tuple[int, int, int, int]:
    x0, y0, x1, y1 = scene.box
    left, top = math.floor(x0 * UNITS), math.floor(-y1 * UNITS)
    return left, top, math.ceil(x1 * UNITS) - left, math.ceil(-y0 * UNITS) - top

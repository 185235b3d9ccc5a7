"""The embedded sample: exact reversible pairs, and symbols of the font that matplotlib ships. Nothing to download.

Each shape of a pair is a class of its own, so that a selection among different classes may find its partner.
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from functools import cache, lru_cache
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from pipeline.datasets.item import SAMPLE_PREFIX
from riot import geometry, groundtruth  # modules of theirs are loaded when a picture is drawn, not when it is listed
from riot.errors import SilhouetteError
from riot.geometry.shape import Shape
from riot.parameters import ShapeParameters
from riot.types import FloatArray

if TYPE_CHECKING:
    from riot.groundtruth.pairs import ExactPair

_SIDE = 256
"""Side, in pixels, of the picture of a pair's shape, and height of the glyphs."""
_FINER = 4
"""Pixels are means of so many squared."""
_MARGIN = 8
_SEED = 2018

_PIECES = (3, 4, 4, 5)
"""Number of pieces of each exact pair; four-pieced ones are the commonest in collections."""

_SYMBOLS: dict[str, str] = {
    "animal": "mouse 🐭 cow 🐮 cat 🐱 monkey 🐵",
    "arrow": "right-arrow ➡ double-arrow ⬌ head ➤ round-arrow ➜ wedge-tailed-arrow ➽ swooping-arrow ➥ "
    "drafted-arrow ➛ circled-arrow ➲ feathered-arrow ➳ teardrop-arrow ➻",
    "card": "spade ♠ heart ♥ diamond ♦ club ♣",
    "chess": "king ♚ queen ♛ rook ♜ bishop ♝ knight ♞ pawn ♟",
    "cross": "greek-cross ✚ club-spoked-cross ✤ balloon-spoked-cross ✣ multiplication-sign ✖ ballot-cross ✘",
    "flower": "florette ✿ clover ☘ lily ⚜ floral-heart ❦ flower ⚘ pinwheel ❃ petalled ❋",
    "hand": "pointing-hand ☛ raised-finger ☝ victory-sign ✌ writing-hand ✍",
    "music": "eighth ♪ beamed ♬ flat ♭ sharp ♯",
    "polygon": "triangle ▲ square ■ pentagon ⬟ hexagon ⬢ circle ● half-disc ◗ parallelogram ▰ piece-of-shogi ☗",
    "sign": "mercury ☿ neptune ♆ chiron ⚷ taurus ♉ leo ♌ tick ✔ paragraph ❡",
    "sky": "cloud ☁ moon ☽ lightning ⚡ snowflake ❄",
    "star": "five-pointed-star ★ four-pointed-star ✦ six-pointed-star ✶ eight-pointed-star ✸ twelve-pointed-star ✹ "
    "sixteen-pointed-star ✺ thin-star ✴",
    "thing": "telephone ☎ umbrella ☂ anchor ⚓ flag ⚑ aeroplane ✈ wheel ☸ cup ☕ urn ⚱ skull ☠ imp 😈",
    "tool": "scissors ✂ hammers ⚒ swords ⚔ gear ⚙ scales ⚖ alembic ⚗ pencil ✏ nib ✒",
}
"""Class → names and characters, with one solid dominant part each, once holes are filled."""


@dataclass(frozen=True)
class SamplePair:
    """One side of an exact pair."""

    pieces: int
    seed: int
    side: str


@dataclass(frozen=True)
class Glyph:
    """A character of DejaVu Sans."""

    character: str


def definitions() -> list[tuple[str, str, str, str]]:
    """Name, class, source and digest of each shape of the sample, sorted by name."""
    rows = []
    for name, (cls, content) in _contents().items():
        rows.append((name, cls, SAMPLE_PREFIX + name, _digest(content)))
    return rows


def shape(source: str, parameters: ShapeParameters | None = None) -> Shape:
    """The shape of a ``sample:<name>``, from its picture; raises `SilhouetteError` for an unknown name."""
    return geometry.silhouette.mask_shape(picture(source), source.removeprefix(SAMPLE_PREFIX), parameters)


def picture(source: str) -> FloatArray:
    """Grey values, (rows, columns), 0 … 255, light on dark, of a ``sample:<name>``."""
    try:
        _, content = _contents()[source.removeprefix(SAMPLE_PREFIX)]
    except KeyError:
        raise SilhouetteError("unreadable", f"{source}: the sample has no such shape; start the run anew") from None
    return _draw_glyph(content) if isinstance(content, Glyph) else _draw_pair(content)


@cache
def _contents() -> dict[str, tuple[str, SamplePair | Glyph]]:
    contents: dict[str, tuple[str, SamplePair | Glyph]] = {}
    for number, pieces in enumerate(_PIECES):
        for side in "ab":
            name = f"pair{number:02d}-{side}"
            contents[name] = (name, SamplePair(pieces, _SEED + number, side))
    for cls, text in _SYMBOLS.items():
        words = text.split()
        for name, character in zip(words[::2], words[1::2], strict=True):
            contents[f"{cls}-{name}"] = (cls, Glyph(character))
    return dict(sorted(contents.items()))


def _digest(content: SamplePair | Glyph) -> str:
    definition: dict[str, object] = {"side": _SIDE, "finer": _FINER, "margin": _MARGIN}
    if isinstance(content, Glyph):
        definition |= {"font": _font_digest(), "character": ord(content.character)}
    else:
        definition |= {"pieces": content.pieces, "seed": content.seed, "of": content.side}
    return hashlib.sha256(json.dumps(definition, sort_keys=True).encode()).hexdigest()


def _font() -> Path:
    # Named in full: looking fonts up by family would depend on what else is installed.
    # Where matplotlib's package lies is asked, and the package is not loaded: that takes half a second.
    matplotlib = find_spec("matplotlib")
    if matplotlib is None or matplotlib.origin is None:
        raise SilhouetteError("unreadable", "the sample needs matplotlib, whose font it draws; install it")
    return Path(matplotlib.origin).parent / "mpl-data" / "fonts" / "ttf" / "DejaVuSans.ttf"


@cache
def _font_digest() -> str:
    return hashlib.sha256(_font().read_bytes()).hexdigest()


@lru_cache(maxsize=4)  # the two sides are mostly asked for one after the other
def _pair(pieces: int, seed: int) -> ExactPair:
    return groundtruth.pairs.exact_pair(pieces, seed)


def _draw_pair(content: SamplePair) -> FloatArray:
    pair = _pair(content.pieces, content.seed)
    polygon = pair.p if content.side == "a" else pair.q
    low, extent = polygon.min(axis=0), np.ptp(polygon, axis=0)
    inner = (_SIDE - 2 * _MARGIN) * _FINER
    placed = (polygon - low) * (inner / extent.max()) + _MARGIN * _FINER
    placed[:, 1] = _SIDE * _FINER - placed[:, 1]  # rows run downwards
    image = Image.new("L", (_SIDE * _FINER, _SIDE * _FINER))
    ImageDraw.Draw(image).polygon([(float(x), float(y)) for x, y in placed], fill=255)
    return np.asarray(image.reduce(_FINER), dtype=np.float64)


def _draw_glyph(content: Glyph) -> FloatArray:
    font = ImageFont.truetype(str(_font()), _SIDE * _FINER, layout_engine=ImageFont.Layout.BASIC)
    left, top, right, bottom = font.getbbox(content.character)
    border = _MARGIN * _FINER
    image = Image.new("L", (int(right - left) + 2 * border, int(bottom - top) + 2 * border))
    ImageDraw.Draw(image).text((border - left, border - top), content.character, fill=255, font=font)
    return np.asarray(image.reduce(_FINER), dtype=np.float64)

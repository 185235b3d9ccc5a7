"""Real files, and ways to damage them: strategies for the fuzz tests."""

from __future__ import annotations

import io
import re

import numpy as np
from hypothesis import strategies as st
from PIL import Image, ImageDraw

from riot.geometry.bend import bend_shape
from riot.geometry.modes import modes
from riot.groundtruth.pairs import exact_pair, exact_transform
from riot.motion import with_motion
from riot.transform.history import History, HistoryStep
from riot.transform.riot_file import to_json

Damage = tuple[str, int, int, int]
"""What is done, where, how much of it, and with which value; places are taken modulo the length."""

KINDS = ("flip", "set", "cut", "drop", "repeat", "swap", "splice", "number", "token")
NUMBERS = (
    b"nan",
    b"-1",
    b"0",
    b"1e999",
    b"-1e308",
    b"1e-320",
    b"Infinity",
    b"99999999999999999999",
    b"2147483648",
    b'"x"',
)
TOKENS = (
    *(b"null", b"[]", b"{}", b"[[[[", b'""', b"true", b"<use href='#a'/>", b"<g id='a'>", b"</g>", b"%", b"url(#a)"),
    *(b"<!DOCTYPE svg>", b"<style>*{fill:none}</style>", b"\0", b"\xff\xfe", b"&#0;", b"transform='scale(0)'", b"z"),
)  # fmt: skip


def pictures() -> list[bytes]:
    """The same few silhouettes in every format and mode that is read."""
    image = Image.new("L", (48, 40))
    ImageDraw.Draw(image).polygon([(6, 4), (40, 9), (44, 30), (21, 22), (9, 35)], fill=255)
    alpha = Image.merge("LA", (image, image))
    made = [("PNG", image, {}), ("PNG", image.convert("P"), {}), ("PNG", alpha, {}), ("PNG", image.convert("1"), {})]
    made += [("GIF", image, {}), ("GIF", image, {"save_all": True, "append_images": [image.rotate(9)]})]
    made += [("BMP", image, {}), ("BMP", image.convert("RGB"), {}), ("JPEG", image, {})]
    made += [("TIFF", image, {"compression": one}) for one in (None, "tiff_lzw", "tiff_deflate", "packbits")]
    made += [("TIFF", Image.fromarray(np.asarray(image, dtype=np.float32)), {})]
    return [_encoded(form, picture, options) for form, picture, options in made]


def drawings() -> list[bytes]:
    """SVG files that use all that is understood."""
    head = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 90" width="20mm">'
    bodies = (
        '<path d="M10 10 C 20 80, 80 80, 90 10 S 40 5 30 30 Q 20 9 15 40 T 5 5 A 9 4 30 1 0 40 40 z M30 30h9v9H30z"/>',
        '<g transform="rotate(20 5 5) scale(.5,2) skewX(9)"><rect x="9" y="9" width="40" height="20" rx="4"/></g>',
        '<defs><circle id="c" r="8"/></defs><use href="#c" x="30" y="20"/><ellipse cx="40" cy="30" rx="20" ry="9"/>',
        '<rect width="100%" height="100%" fill="#fff"/>'
        '<polygon points="10,10 60.5,12 40,70 1e1,3e1" fill="rgb(9,9,9)"/>',
        "<style>.a{fill:none}#b{fill-rule:evenodd}</style>"
        '<path class="a" d="M0 0h9v9z"/><path id="b" d="M5 5h50v50h-50z"/>',
        '<symbol id="s"><rect width="20" height="20" style="fill:red;opacity:.5"/></symbol><use href="#s"/>',
        '<clipPath id="k"><circle cx="50" cy="50" r="30"/></clipPath>'
        '<mask id="m"><path d="M0 0h99v50z" fill="#fff"/></mask>'
        '<g clip-path="url(#k)" mask="url(#m)"><rect width="90" height="90"/></g>',
        '<marker id="a" markerWidth="3" markerHeight="3"><rect width="2" height="2"/></marker>'
        '<path d="M20 20h50v40" fill="none" stroke="#000" stroke-width="9" stroke-dasharray="20 1"'
        ' marker-end="url(#a)"/>',
        '<filter id="f"><feGaussianBlur stdDeviation="2"/><feOffset dx="3"/></filter>'
        '<pattern id="p" width="4" height="4" patternUnits="userSpaceOnUse"><rect width="4" height="4"/></pattern>'
        '<rect x="9" y="9" width="60" height="50" fill="url(#p)" filter="url(#f)"/>',
    )
    return [f"{head}{body}</svg>".encode() for body in bodies]


def transforms() -> list[bytes]:
    """Finished ``.riot`` files."""
    from dataclasses import replace

    history = History(
        "riot make", ("a" * 64, "b" * 64), (HistoryStep("ingest", {"spacing": 100.0}, "c", ("d",)),), {"a": "1"}
    )
    made = exact_transform(exact_pair(3, 1))
    bend = bend_shape(modes(made.p, 6), np.full(6, 0.01))
    bent = replace(made, p=bend.bent, bend_p=bend)
    return [to_json(one).encode() for one in (made, replace(with_motion(made), history=history), bent)]


def damages(most: int = 6) -> st.SearchStrategy[list[Damage]]:
    """A few damages."""
    number = st.integers(0, 2**31 - 1)
    return st.lists(st.tuples(st.sampled_from(KINDS), number, number, st.integers(0, 255)), min_size=1, max_size=most)


def damaged(data: bytes, other: bytes, done: list[Damage]) -> bytes:
    """The file with all that was done to it; ``other`` is spliced in."""
    for kind, where, much, value in done:
        at = where % (len(data) + 1)
        size = 1 + much % max(1, len(data) // 4)
        head, tail = data[:at], data[at:]
        if kind == "flip" and tail:
            data = head + bytes([tail[0] ^ (1 << value % 8)]) + tail[1:]
        elif kind == "set" and tail:
            data = head + bytes([value]) + tail[1:]
        elif kind == "cut":
            data = head
        elif kind == "drop":
            data = head + tail[size:]
        elif kind == "repeat":
            data = head + tail[:size] * (1 + value % 8) + tail
        elif kind == "swap":
            data = head + tail[size : 2 * size] + tail[:size] + tail[2 * size :]
        elif kind == "splice":
            start = much % (len(other) + 1)
            data = head + other[start : start + size] + tail
        elif kind == "number":
            data = _another_number(data, where, NUMBERS[value % len(NUMBERS)])
        elif kind == "token":
            data = head + TOKENS[value % len(TOKENS)] + tail
    return data


def _another_number(data: bytes, where: int, number: bytes) -> bytes:
    found = list(re.finditer(rb"-?[0-9]+(?:\.[0-9]+)?", data))
    if not found:
        return data
    chosen = found[where % len(found)]
    return data[: chosen.start()] + number + data[chosen.end() :]


def _encoded(form: str, picture: Image.Image, options: dict[str, object]) -> bytes:
    stream = io.BytesIO()
    picture.save(stream, form, **options)
    return stream.getvalue()

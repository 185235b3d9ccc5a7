"""What a transform does, in words: "Bird becomes half-circle". Ours."""

from __future__ import annotations

import re

from pipeline.report.rows import TransformRow

LETTERS = re.compile(r"[^\W\d_]{2,}")
"""What makes a name a word rather than a number."""


def becomes(row: TransformRow) -> str:
    """The transform as a sentence without a stop; the file names of its shapes are not in it where a class says more.

    >>> from pipeline.report.rows import typed_row
    >>> row = typed_row(TransformRow, {"name_i": "bird-12", "class_i": "bird", "name_j": "lion", "class_j": ""})
    >>> becomes(row)
    'Bird becomes lion'
    """
    p, q = (thing(name, kind) for name, kind in row.named_sides)
    return f"One {p} becomes another" if p == q else f"{p[:1].upper()}{p[1:]} becomes {q}"


def thing(name: str, kind: str) -> str:
    """What a shape is: its class if its name only numbers it, else its name, without the class before it.

    >>> thing("device3-11", "device3"), thing("animal-cat", "animal"), thing("HCircle-2", "HCircle")
    ('device 3', 'cat', 'H-circle')
    >>> thing("apple_07", ""), thing("0042", "")
    ('apple 07', 'shape 0042')
    """
    rest = name[len(kind) :] if kind and name.lower().startswith(kind.lower()) else name
    words = plain_words(rest if LETTERS.search(rest) else kind or name)
    return words if LETTERS.search(words) else f"shape {words}"


def plain_words(name: str) -> str:
    """A name as words: its dashes, capitals and numbers set them apart.

    >>> plain_words("sea_snake"), plain_words("glasWare"), plain_words("pair00-a")
    ('sea snake', 'glas ware', 'pair 00 a')
    """
    apart = re.sub(r"(?<=[a-z])(?=[A-Z])|(?<=[a-z])(?=\d)|[-_\s]+", " ", name)
    apart = re.sub(r"\b([A-Z])(?=[A-Z][a-z])", r"\1-", apart).strip()
    return re.sub(r"[A-Z][a-z]+", lambda word: word[0].lower(), apart) or name

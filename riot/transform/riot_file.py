"""The ``.riot`` file: a transform as JSON, exact to the last bit, readable without this project."""

from __future__ import annotations

import contextlib
import json
import math
import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from riot.errors import FormatError
from riot.geometry.limits import JSON_BYTES, TooManyBytes, read_text
from riot.transform import bend_document, history, shape_document
from riot.transform.motion_document import from_document, to_document
from riot.transform.pose import Placement
from riot.transform.shape_document import read_numbers, read_points
from riot.transform.transform import Piece, Transform

if TYPE_CHECKING:
    from riot.geometry.bend import Bend

FORMAT = "riot-transform"
VERSION = 2
"""Of what is written for inputs that are cut as they are. It added the motion, which may be absent, as may the history,
which readers may ignore."""

BENT_VERSION = 3
"""Of what is written where an input was bent: ``p`` and ``q`` are the bent shapes, and ``bend_p`` and ``bend_q`` have
the inputs, and the maps from them."""

READABLE = (1, 2, 3)
"""Versions that can be read."""

MAX_PIECES = 256
"""A file with more pieces is refused: some operations look at every two of them."""

MAX_POINTS = 200_000
"""So is one with more points in all."""


_BENDS = ("bend_p", "bend_q")


def to_json(transform: Transform) -> str:
    """The transform as JSON text; floats in the shortest form that reads back to the same bits.

    >>> from riot.groundtruth.pairs import dudeney, exact_transform
    >>> transform = exact_transform(dudeney())
    >>> from_json(to_json(transform)).angles.tolist() == transform.angles.tolist()
    True
    """
    document: dict[str, Any] = {
        "format": FORMAT,
        "version": BENT_VERSION if _bends(transform) else VERSION,
        "pieces": [
            {"length": piece.length, "lower": piece.lower.tolist(), "upper": piece.upper.tolist()}
            for piece in transform.pieces
        ],
        "angles": transform.angles.tolist(),
        "conjugate_angles": transform.conjugate_angles.tolist(),
        "place_p": [transform.place_p.x, transform.place_p.y, transform.place_p.heading],
        "place_q": [transform.place_q.x, transform.place_q.y, transform.place_q.heading],
        "p": shape_document.to_document(transform.p),
        "q": shape_document.to_document(transform.q),
        "trunk_p": transform.trunk_p.tolist(),
        "trunk_q": transform.trunk_q.tolist(),
        "bound_p": transform.bound_p,
        "bound_q": transform.bound_q,
    }
    document |= {name: bend_document.to_document(bend) for name, bend in _bends(transform).items()}
    if transform.mirrored_q:
        document["mirrored_q"] = True  # readers that do not know it lose nothing but how Q is shown
    if transform.plan is not None:
        document["motion"] = to_document(transform.plan)
    if transform.history is not None:
        document["history"] = history.to_document(transform.history)
    return _compact(document)


def _compact(document: Mapping[str, Any]) -> str:
    return json.dumps(document, ensure_ascii=False, separators=(",", ":"))


def add_history(text: str, origin: history.History) -> str:
    """What `to_json` wrote of a transform without a history, with one; the same bytes as if it had had it.

    It does not read the text, which takes fifty times as long.

    >>> from riot.groundtruth.pairs import dudeney, exact_transform
    >>> from riot.transform.history import History
    >>> origin = History("riot", ("0" * 64, "1" * 64), (), {})
    >>> from_json(add_history(to_json(exact_transform(dudeney())), origin)).history == origin
    True
    """
    return f'{text[:-1]},"history":{_compact(history.to_document(origin))}}}'


def from_json(text: str, where: str = "text") -> Transform:
    """Read what `to_json` wrote; ``where`` names the source in errors.

    >>> from_json("{}")
    Traceback (most recent call last):
    riot.errors.FormatError: text is not a .riot file: it lacks "format": "riot-transform"
    """
    try:
        document = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise FormatError(f"{where} is not a .riot file: it is not JSON ({error})") from None
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise FormatError(f'{where} is not a .riot file: it lacks "format": "{FORMAT}"')
    if document.get("version") not in READABLE:
        raise FormatError(
            f"{where} has version {document.get('version')!r}; this program reads versions "
            f"{', '.join(map(str, READABLE))}: "
            "use the program that wrote it, or construct the transform again"
        )
    try:
        return _transform(document)
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        raise FormatError(f"{where} is damaged: {type(error).__name__}: {error}") from None


def save(transform: Transform, path: str | os.PathLike[str]) -> None:
    """Write a ``.riot`` file, replacing an older one in one step. Raises OSError if it cannot be written.

    >>> from riot.groundtruth.pairs import dudeney, exact_transform
    >>> save(exact_transform(dudeney()), "dudeney.riot")
    >>> len(load("dudeney.riot"))
    4
    """
    target = Path(path)
    temporary = target.with_name(f".{target.name}.{os.getpid()}.tmp")
    text = to_json(transform)
    try:
        temporary.write_text(text, encoding="utf-8")
        temporary.replace(target)
    except OSError as error:
        with contextlib.suppress(OSError):
            temporary.unlink()
        raise OSError(error.errno, error.strerror, str(target)) from error


def load(path: str | os.PathLike[str]) -> Transform:
    """Read a ``.riot`` file; `FormatError` if it is none, FileNotFoundError if it is not there.

    >>> from riot.groundtruth.pairs import dudeney, exact_transform
    >>> save(exact_transform(dudeney()), "dudeney.riot")
    >>> load("dudeney.riot").p.name
    'P'
    """
    try:
        text = read_text(Path(path), JSON_BYTES)
    except TooManyBytes as error:
        raise FormatError(f"{path} is no .riot file of ours: {error}; construct the transform again") from error
    return from_json(text, str(path))


def _bends(transform: Transform) -> dict[str, Bend]:
    bends = zip(_BENDS, (transform.bend_p, transform.bend_q), strict=True)
    return {name: bend for name, bend in bends if bend is not None}


def _bound(value: Any) -> float:
    bound = float(value)
    if math.isinf(bound):  # nan where it is not known
        raise ValueError("a bound of the IoU is not finite")
    return bound


def _piece(document: dict[str, Any]) -> Piece:
    (length,) = read_numbers([document["length"]])
    lower, upper = read_points(document["lower"]), read_points(document["upper"])
    ends = np.array([[0.0, 0.0], [length, 0.0]])
    if length <= 0.0 or not (np.array_equal(lower[[0, -1]], ends) and np.array_equal(upper[[-1, 0]], ends)):
        raise ValueError(f"a piece's arcs do not run between (0, 0) and ({length}, 0)")
    return Piece(length, lower, upper)


def _transform(document: dict[str, Any]) -> Transform:
    _refuse_size(document)
    pieces = tuple(_piece(piece) for piece in document["pieces"])
    angles, conjugate = np.array(read_numbers(document["angles"])), np.array(read_numbers(document["conjugate_angles"]))
    if len(pieces) < 3 or angles.shape != (len(pieces),) or conjugate.shape != angles.shape:
        raise ValueError(f"{len(pieces)} pieces, {angles.shape} and {conjugate.shape} angles")
    transform = Transform(
        pieces=pieces,
        angles=angles,
        conjugate_angles=conjugate,
        place_p=Placement(*read_numbers(document["place_p"])),
        place_q=Placement(*read_numbers(document["place_q"])),
        p=shape_document.from_document(document["p"]),
        q=shape_document.from_document(document["q"]),
        trunk_p=read_points(document["trunk_p"]),
        trunk_q=read_points(document["trunk_q"]),
        bound_p=_bound(document["bound_p"]),
        bound_q=_bound(document["bound_q"]),
        mirrored_q=document.get("mirrored_q", False) is True,
    )
    if document["version"] == BENT_VERSION:
        bend_p, bend_q = (
            bend_document.from_document(document[name], bent) if name in document else None
            for name, bent in zip(_BENDS, (transform.p, transform.q), strict=True)
        )
        transform = replace(transform, bend_p=bend_p, bend_q=bend_q)
    if document.get("history") is not None:
        transform = replace(transform, history=history.from_document(document["history"]))
    if document.get("motion") is None:
        return transform
    plan = from_document(document["motion"], transform.chain, transform.place_p, transform.place_q)
    return replace(transform, plan=plan)


def _refuse_size(document: dict[str, Any]) -> None:
    pieces = document["pieces"]
    if len(pieces) > MAX_PIECES:
        raise ValueError(f"{len(pieces)} pieces are more than the limit of {MAX_PIECES}")
    points = sum(len(piece[side]) for piece in pieces for side in ("lower", "upper"))
    points += sum(len(document[side]["points"]) for side in "pq")
    if document["version"] == BENT_VERSION:
        points += sum(bend_document.count_values(document[side]) for side in _BENDS if side in document)
    if points > MAX_POINTS:
        raise ValueError(f"{points} points are more than the limit of {MAX_POINTS}")

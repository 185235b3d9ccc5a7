"""The ``.riot`` file: a transform as JSON, exact to the last bit, readable without this project."""

from __future__ import annotations

import contextlib
import json
import math
import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from riot.errors import FormatError
from riot.geometry.limits import JSON_BYTES, TooManyBytes, read_text
from riot.geometry.shape import Shape
from riot.transform import history
from riot.transform.motion_document import from_document, to_document
from riot.transform.pose import Placement
from riot.transform.transform import Piece, Transform
from riot.types import FloatArray

FORMAT = "riot-transform"
VERSION = 2
"""Of what is written. Version 2 added the motion, which may be absent, as may the history, which readers may ignore."""

READABLE = (1, 2)
"""Versions that can be read."""

MAX_PIECES = 256
"""A file with more pieces is refused: some operations look at every two of them."""

MAX_POINTS = 200_000
"""So is one with more points in all."""


def to_json(transform: Transform) -> str:
    """The transform as JSON text; floats in the shortest form that reads back to the same bits.

    >>> from riot.groundtruth.pairs import dudeney, exact_transform
    >>> transform = exact_transform(dudeney())
    >>> from_json(to_json(transform)).angles.tolist() == transform.angles.tolist()
    True
    """
    document: dict[str, Any] = {
        "format": FORMAT,
        "version": VERSION,
        "pieces": [
            {"length": piece.length, "lower": piece.lower.tolist(), "upper": piece.upper.tolist()}
            for piece in transform.pieces
        ],
        "angles": transform.angles.tolist(),
        "conjugate_angles": transform.conjugate_angles.tolist(),
        "place_p": [transform.place_p.x, transform.place_p.y, transform.place_p.heading],
        "place_q": [transform.place_q.x, transform.place_q.y, transform.place_q.heading],
        "p": _shape_document(transform.p),
        "q": _shape_document(transform.q),
        "trunk_p": transform.trunk_p.tolist(),
        "trunk_q": transform.trunk_q.tolist(),
        "bound_p": transform.bound_p,
        "bound_q": transform.bound_q,
    }
    if transform.plan is not None:
        document["motion"] = to_document(transform.plan)
    if transform.history is not None:
        document["history"] = history.to_document(transform.history)
    return json.dumps(document, ensure_ascii=False, separators=(",", ":"))


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
            f"{' and '.join(map(str, READABLE))}: "
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


def _shape_document(shape: Shape) -> dict[str, Any]:
    return {
        "name": shape.name,
        "points": shape.points.tolist(),
        "feature": np.flatnonzero(shape.feature).tolist(),
        "to_source": shape.to_source.tolist(),
    }


def _points(value: Any) -> FloatArray:
    points = np.asarray(value, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 2 or not np.isfinite(points).all():
        raise ValueError(f"points of shape {points.shape} where (k, 2) finite numbers belong")
    return points


def _finite(values: Any) -> list[float]:
    numbers = [float(value) for value in values]
    if not np.isfinite(numbers).all():
        raise ValueError(f"{numbers} where finite numbers belong")
    return numbers


def _bound(value: Any) -> float:
    bound = float(value)
    if math.isinf(bound):  # nan where it is not known
        raise ValueError("a bound of the IoU is not finite")
    return bound


def _piece(document: dict[str, Any]) -> Piece:
    (length,) = _finite([document["length"]])
    lower, upper = _points(document["lower"]), _points(document["upper"])
    ends = np.array([[0.0, 0.0], [length, 0.0]])
    if length <= 0.0 or not (np.array_equal(lower[[0, -1]], ends) and np.array_equal(upper[[-1, 0]], ends)):
        raise ValueError(f"a piece's arcs do not run between (0, 0) and ({length}, 0)")
    return Piece(length, lower, upper)


def _shape(document: dict[str, Any]) -> Shape:
    points = _points(document["points"])
    feature = np.zeros(len(points), dtype=bool)
    feature[document["feature"]] = True
    to_source = np.asarray(document["to_source"], dtype=np.float64).reshape(2, 3)
    if not np.isfinite(to_source).all():
        raise ValueError("a shape's to_source is not finite")
    return Shape(points, feature, str(document["name"]), to_source)


def _transform(document: dict[str, Any]) -> Transform:
    _refuse_size(document)
    pieces = tuple(_piece(piece) for piece in document["pieces"])
    angles, conjugate = np.array(_finite(document["angles"])), np.array(_finite(document["conjugate_angles"]))
    if len(pieces) < 3 or angles.shape != (len(pieces),) or conjugate.shape != angles.shape:
        raise ValueError(f"{len(pieces)} pieces, {angles.shape} and {conjugate.shape} angles")
    transform = Transform(
        pieces=pieces,
        angles=angles,
        conjugate_angles=conjugate,
        place_p=Placement(*_finite(document["place_p"])),
        place_q=Placement(*_finite(document["place_q"])),
        p=_shape(document["p"]),
        q=_shape(document["q"]),
        trunk_p=_points(document["trunk_p"]),
        trunk_q=_points(document["trunk_q"]),
        bound_p=_bound(document["bound_p"]),
        bound_q=_bound(document["bound_q"]),
    )
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
    if points > MAX_POINTS:
        raise ValueError(f"{points} points are more than the limit of {MAX_POINTS}")

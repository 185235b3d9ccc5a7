"""Shapes, points and numbers of a ``.riot`` file as JSON values, read with care: the file may be anybody's."""

from __future__ import annotations

from typing import Any

import numpy as np

from riot.geometry.shape import Shape
from riot.types import FloatArray


def to_document(shape: Shape) -> dict[str, Any]:
    """A shape as JSON values."""
    return {
        "name": shape.name,
        "points": shape.points.tolist(),
        "feature": np.flatnonzero(shape.feature).tolist(),
        "to_source": shape.to_source.tolist(),
    }


def from_document(document: dict[str, Any]) -> Shape:
    """Read what `to_document` wrote; ArithmeticError, LookupError, TypeError or ValueError if it is damaged."""
    points = read_points(document["points"])
    feature = np.zeros(len(points), dtype=bool)
    feature[document["feature"]] = True
    to_source = np.asarray(document["to_source"], dtype=np.float64).reshape(2, 3)
    if not np.isfinite(to_source).all():
        raise ValueError("a shape's to_source is not finite")
    return Shape(points, feature, str(document["name"]), to_source)


def read_points(value: Any) -> FloatArray:
    """(k, 2) finite numbers.

    >>> read_points([[0, 1], [2, 3]]).shape
    (2, 2)
    """
    points = np.asarray(value, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 2 or not np.isfinite(points).all():
        raise ValueError(f"points of shape {points.shape} where (k, 2) finite numbers belong")
    return points


def read_numbers(values: Any) -> list[float]:
    """Finite numbers.

    >>> read_numbers([1, 2.5])
    [1.0, 2.5]
    """
    numbers = [float(value) for value in values]
    if not np.isfinite(numbers).all():
        raise ValueError(f"{numbers} where finite numbers belong")
    return numbers

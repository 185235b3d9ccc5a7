"""Equality, hash and one-line text of data classes whose fields are arrays, by content. Ours."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np


class ByContent:
    """What a data class inherits, declared with ``eq=False``: equal are objects of one class with equal content.

    Fields declared with ``compare=False`` do not count.

    Numbers count to the last bit: nan equals the same nan, and 0.0 differs from -0.0. The hash is computed at every
    call; what looks values up often keeps them by identity instead (`riot.transform.transform_cache`).

    >>> house == house.renamed("home"), house == house.renamed("home").renamed("house")
    (False, True)
    """

    def __eq__(self, other: object) -> bool:
        if self is other:
            return True
        if type(self) is not type(other):
            return NotImplemented
        return bool(content(self) == content(other))

    def __hash__(self) -> int:
        return hash(content(self))


def content(value: Any) -> Any:
    """The content of a value as nested tuples of what can be hashed."""
    if isinstance(value, np.ndarray):
        return "array", value.dtype.str, value.shape, value.tobytes()
    if isinstance(value, float):
        return "float", struct.pack("<d", value)
    if isinstance(value, (tuple, list)):
        return tuple(content(item) for item in value)
    if isinstance(value, Mapping):
        return "mapping", frozenset((key, content(item)) for key, item in value.items())
    if is_dataclass(value):
        return type(value), tuple(content(getattr(value, field.name)) for field in fields(value) if field.compare)
    return value


def count(number: int, noun: str) -> str:
    """A number with its noun, in the plural where that is due.

    >>> count(1, "piece"), count(4, "piece")
    ('1 piece', '4 pieces')
    """
    return f"{number} {noun}{'' if number == 1 else 's'}"

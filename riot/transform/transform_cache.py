"""Functions of a transform that are computed once for each transform."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import TypeVar
from weakref import finalize

from riot.transform.transform import Transform

Value = TypeVar("Value")


def once_per_transform(function: Callable[[Transform], Value]) -> Callable[[Transform], Value]:
    """Compute ``function`` once for each transform, which counts by identity, and keep the value while that lives.

    A transform is data that nobody changes, so its value stays the same. The value must not refer to the transform,
    which would otherwise live forever.
    """
    values: dict[int, Value] = {}  # by identity: a hash by content would read every array at each look-up

    @wraps(function)
    def cached(transform: Transform) -> Value:
        key = id(transform)
        if key not in values:
            values[key] = function(transform)
            finalize(transform, values.pop, key, None).atexit = False
        return values[key]

    return cached

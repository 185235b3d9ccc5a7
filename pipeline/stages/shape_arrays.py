"""Shapes as ragged arrays, and failures as rows: the form of the artifacts of stages of shapes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, TypeVar

import numpy as np

from pipeline.store.artifact import AnyArray, Artifact
from riot.errors import RiotError
from riot.geometry.shape import Shape

T = TypeVar("T")
ErrorRow = dict[str, Any]


def attempt(index: int, function: Callable[[], T], errors: list[ErrorRow]) -> T | None:
    """Call ``function`` for the item ``index`` of a batch; on a failure append a row to ``errors`` and return None.

    Errors of the machine (memory, files) are raised: they do not depend on the item and must not be stored.

    >>> errors = []
    >>> attempt(3, lambda: 1 / 0, errors), errors[0]["type"]
    (None, 'ZeroDivisionError')
    """
    try:
        return function()
    except (RiotError, ArithmeticError, AssertionError, LookupError, TypeError, ValueError) as error:
        # Our own errors, and the builtin ones that a deterministic function would raise again.
        errors.append(error_row(index, error))
        return None


def attempt_each(batch: Artifact, function: Callable[[Shape], T], errors: list[ErrorRow]) -> list[T | None]:
    """Call ``function`` for each shape of a batch, as `attempt`; None also where ingest failed.

    >>> square = Shape(np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]), np.ones(4, dtype=bool))
    >>> attempt_each(Artifact(pack_shapes([square, None])), lambda shape: round(shape.perimeter, 9), [])
    [4.0, None]
    """
    results: list[T | None] = []
    for index in range(count_shapes(batch)):
        shape = unpack_shape(batch, index)
        results.append(None if shape is None else attempt(index, partial(function, shape), errors))
    return results


def error_row(index: int, error: BaseException) -> ErrorRow:
    """A failure as plain values: index within the batch, type, reason (one word), message."""
    reason = getattr(error, "reason", "") or ("unexpected" if not isinstance(error, RiotError) else "")
    return {"index": index, "type": type(error).__name__, "reason": reason, "message": str(error)}


def pack_shapes(shapes: Sequence[Shape | None]) -> dict[str, AnyArray]:
    """Shapes as arrays: ``offsets`` (k+1,) int64 into ``points`` (M, 2) and ``feature`` (M,), ``to_source`` (k, 2, 3).

    A missing shape has no points. Names are left out, since the geometry does not depend on them.
    """
    lengths = np.array([0 if shape is None else len(shape.points) for shape in shapes], dtype=np.int64)
    present = [shape for shape in shapes if shape is not None]
    to_source = [np.eye(2, 3) if shape is None else shape.to_source for shape in shapes]
    return {
        "offsets": np.concatenate([np.zeros(1, np.int64), np.cumsum(lengths)]),
        "points": np.concatenate([np.empty((0, 2)), *(shape.points for shape in present)]),
        "feature": np.concatenate([np.empty(0, bool), *(shape.feature for shape in present)]),
        "to_source": np.array(to_source).reshape(-1, 2, 3),
    }


def unpack_shape(artifact: Artifact, index: int, name: str = "") -> Shape | None:
    """The shape at ``index`` of a batch; None where ingest failed."""
    arrays = artifact.arrays
    low, high = int(arrays["offsets"][index]), int(arrays["offsets"][index + 1])
    if low == high:
        return None
    # Copies: compiled kernels would compile a second time for read-only arrays.
    return Shape(
        np.array(arrays["points"][low:high]),
        np.array(arrays["feature"][low:high]),
        name,
        np.array(arrays["to_source"][index]),
    )


def count_shapes(artifact: Artifact) -> int:
    """Number of items of a batch, failed ones included."""
    return len(artifact.arrays["offsets"]) - 1


def expect_shape(artifact: Artifact, index: int, name: str = "") -> Shape:
    """The shape at ``index``, which exists according to the plan; raises LookupError if it does not."""
    shape = unpack_shape(artifact, index, name)
    if shape is None:
        raise LookupError(f"the batch has no shape at {index}")
    return shape


def join_single(artifacts: Sequence[Artifact]) -> Artifact:
    """The artifact of a batch from the artifacts of its single shapes.

    Arrays whose names end in ``offsets`` are running sums from 0, as in every stage of shapes; all others are
    concatenated.
    """
    arrays: dict[str, AnyArray] = {}
    for name in artifacts[0].arrays:
        pieces = [artifact.arrays[name] for artifact in artifacts]
        if name.endswith("offsets"):
            sizes = np.concatenate([np.zeros(1, np.int64), *(np.diff(offsets) for offsets in pieces)])
            arrays[name] = np.cumsum(sizes, dtype=pieces[0].dtype)
        else:
            arrays[name] = np.concatenate(pieces)
    errors = [
        {**row, "index": index} for index, artifact in enumerate(artifacts) for row in artifact.document["errors"]
    ]
    return Artifact(arrays, {"errors": errors})

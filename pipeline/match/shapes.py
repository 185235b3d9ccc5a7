"""The shapes of a finished run by number, read from its store."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from pipeline.errors import PayloadError, StartError
from pipeline.match.search import AGAIN, MinedRun
from pipeline.stages.shape_arrays import count_shapes, expect_shape
from riot.geometry.shape import Shape


def read_shapes(mined: MinedRun, numbers: Collection[int]) -> dict[int, Shape]:
    """The shapes of a run with these numbers, under their names; raises `StartError` if one is not in the store."""
    shapes: dict[int, Shape] = {}
    first = 0
    try:
        for key in mined.trunks:
            batch = mined.store.get("ingest", _inputs(mined, "trunks", key)[0])
            here = mined.numbers[first : first + count_shapes(batch)].tolist()
            first += len(here)
            shapes |= {
                number: expect_shape(batch, index, mined.names[number])
                for index, number in enumerate(here)
                if number in numbers
            }
    except (LookupError, PayloadError, OSError) as error:
        reason = error.args[0] if isinstance(error, LookupError) else error
        raise StartError(
            f"{mined.store.root}: shapes of {mined.folder} are gone or altered ({reason}); {AGAIN}"
        ) from error
    return shapes


def _inputs(mined: MinedRun, stage: str, key: str) -> Sequence[str]:
    entry = mined.store.entry(stage, key)
    if entry is None:
        raise LookupError(f"{stage}/{key[:12]}")
    inputs: Sequence[str] = entry.parts["inputs"]
    return inputs

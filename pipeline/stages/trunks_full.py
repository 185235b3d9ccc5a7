"""Full trunks of one selected shape."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pipeline.stages.items import ErrorRow, attempt, expect_shape
from pipeline.stages.trunk_arrays import pack_trunks
from pipeline.store.artifact import Artifact
from riot.scores.trunks import full_trunks


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: int) -> Artifact:
    """The shape at ``spec`` of a batch → its trunks, packed as a batch of one."""
    (batch,), (settings,) = inputs, parameters
    errors: list[ErrorRow] = []
    shape = expect_shape(batch, spec)
    return Artifact(pack_trunks([attempt(0, lambda: full_trunks(shape, settings), errors)]), {"errors": errors})

"""QCRS by trunks of three vertices alone, and by those of six and more: policy ``varied`` fills its pool from them too.

A shape has ten times as many trunks of four and five vertices, among which a good pair of triangles or of hexagons is
seldom the best; searching these alone takes a tenth of the time of all (ours).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from pipeline.config.schema import Config
from pipeline.plan.progress import Progress
from pipeline.plan.work_item import WorkItem
from pipeline.stages.planning import between_batches
from pipeline.stages.qcrs import prepare as stack_of_batch
from pipeline.stages.stage import Stage
from pipeline.store.artifact import Artifact
from riot import scores

if TYPE_CHECKING:
    from riot.parameters import QcrsParameters
    from riot.scores.trunk_stack import TrunkStack

RARE = ((3, 3), (6, int(np.iinfo(np.int8).max)))
"""Least and greatest number of vertices of the trunks that are searched alone."""

COLUMNS = ("i", "j", "score", "n")


def prepare(batch: Artifact) -> tuple[TrunkStack, ...]:
    """The stacks of a batch's trunks of each range of `RARE`."""
    whole = stack_of_batch(batch)
    return tuple(scores.trunk_stack.of_sizes(whole, least, most) for least, most in RARE)


def run(inputs: Sequence[tuple[TrunkStack, ...]], parameters: Sequence[QcrsParameters], spec: bool) -> Artifact:
    """Stacks of one batch (``spec``: with itself) or of two → rows i, j (local), score and n of each range's trunks.

    Only pairs with such trunks have a row.
    """
    (settings,) = parameters
    blocks = [
        scores.qcrs.score_block(first, last, settings, same=spec)
        for first, last in zip(inputs[0], inputs[-1], strict=True)
    ]
    return Artifact({name: np.concatenate([getattr(block, name)[block.n > 0] for block in blocks]) for name in COLUMNS})


def items(progress: Progress) -> list[WorkItem]:
    """A work item for every two batches, and for each batch with itself."""
    return between_batches(progress, "qcrs_rare")


def fills_by_size(config: Config) -> bool:
    """Whether a run fills its pool by the number of vertices, and scores every pair."""
    return config.select.policy == "varied" and config.qcrs.mode == "all"


STAGE = Stage(
    name="qcrs_rare",
    unit="blocks of pairs",
    after=("trunks",),
    parameters=("qcrs",),
    items=items,
    run=run,
    scope="block",
    prepare=prepare,
    wanted=fills_by_size,
    tile=8,
)

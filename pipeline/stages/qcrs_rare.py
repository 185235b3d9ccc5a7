"""QCRS by trunks of three vertices alone, and by those of six and more: policy ``varied`` fills its pool from them too.

A shape has ten times as many trunks of four and five vertices, among which a good pair of triangles or of hexagons is
seldom the best; searching these alone takes a tenth of the time of all (ours).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.config.schema import Config
from pipeline.plan.progress import Progress
from pipeline.plan.sub_block import Sides
from pipeline.plan.work_item import WorkItem
from pipeline.stages.block_rows import Columns, ReusingBlock, block_rows, is_block
from pipeline.stages.planning import between_groups
from pipeline.stages.qcrs import stack_of_batch
from pipeline.stages.stage import Stage
from pipeline.store.artifact import Artifact
from riot import scores

if TYPE_CHECKING:
    from riot.parameters import QcrsParameters
    from riot.scores.trunk_stack import TrunkStack

RARE = ((3, 3), (6, int(np.iinfo(np.int8).max)))
"""Least and greatest number of vertices of the trunks that are searched alone."""

COLUMNS = ("i", "j", "score", "n")


@dataclass(frozen=True)
class RareTrunks:
    """The stacks of a batch's trunks of each range of `RARE`."""

    stacks: tuple[TrunkStack, ...]

    def __len__(self) -> int:
        return len(self.stacks[0])


def prepare(artifact: Artifact) -> RareTrunks | Artifact:
    """The rare trunks of a batch; an older block as it is."""
    if is_block(artifact):
        return artifact
    whole = stack_of_batch(artifact)
    return RareTrunks(tuple(scores.trunk_stack.of_sizes(whole, least, most) for least, most in RARE))


def run(inputs: Sequence[Any], parameters: Sequence[QcrsParameters], spec: Sides | ReusingBlock) -> Artifact:
    """Rare trunks of the batches of one group or two → rows i, j (local to them), score and n of each range's trunks.

    Only pairs with such trunks have a row.
    """
    (settings,) = parameters

    def score(a: RareTrunks, b: RareTrunks, same: bool) -> Columns:
        blocks = [
            scores.qcrs.score_block(first, last, settings, same=same)
            for first, last in zip(a.stacks, b.stacks, strict=True)
        ]
        return {name: np.concatenate([getattr(block, name)[block.n > 0] for block in blocks]) for name in COLUMNS}

    return block_rows(inputs, spec, score)


def items(progress: Progress) -> list[WorkItem]:
    """A work item for every two spans of groups, and for each with itself, as many pairs as some four other blocks."""
    return between_groups(progress, "qcrs_rare", progress.spans[0])


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

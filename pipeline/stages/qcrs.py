"""Quick cross-reversibility scores of a block: all pairs of two groups, or of one with itself (paper §5.2)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.config.schema import Config
from pipeline.plan.progress import Progress
from pipeline.plan.sub_block import Sides, SubBlock
from pipeline.plan.work_item import WorkItem
from pipeline.stages.block_rows import STARTS, Columns, ReusingBlock, block_rows, is_block, ordered, side_starts
from pipeline.stages.planning import between_groups
from pipeline.stages.stage import Column, Stage, SubBlocks, TableColumns
from pipeline.stages.trunk_arrays import CORNERS
from pipeline.store.artifact import Artifact
from riot import scores

if TYPE_CHECKING:
    from riot.scores.qcrs import BlockScores
    from riot.scores.trunk_stack import TrunkStack

COLUMNS = ("i", "j", "score", "n", "trunk_i", "trunk_j", "shift")


def prepare(artifact: Artifact) -> TrunkStack | Artifact:
    """The stack of a batch's trunks, which the scores read; an older block as it is."""
    return artifact if is_block(artifact) else stack_of_batch(artifact)


def stack_of_batch(batch: Artifact) -> TrunkStack:
    """The stack of a batch's trunks."""
    # Copies: compiled kernels would compile a second time for read-only arrays.
    names = ("trunk_offsets", "offsets", "areas", "leaf_offsets", "leaves", *CORNERS)
    arrays = {name: np.array(batch.arrays[name]) for name in names}
    whole = scores.trunks.Trunks(arrays["offsets"], areas=arrays["areas"], **{name: arrays[name] for name in CORNERS})
    return scores.trunk_stack.TrunkStack(
        starts=arrays["trunk_offsets"],
        offsets=whole.offsets,
        edges=whole.edges,
        alphas=whole.alphas,
        betas=whole.betas,
        areas=whole.areas,
        leaf_starts=arrays["leaf_offsets"],
        leaves=arrays["leaves"],
    )


def run(inputs: Sequence[Any], parameters: Sequence[Any], spec: Sides | ReusingBlock | SubBlock) -> Artifact:
    """Stacks of the batches of one group or two → a row for each pair, by (i, j), which are local to the groups."""
    (settings,) = parameters
    if isinstance(spec, SubBlock):
        first, second = ([inputs[number] for number in side] for side in spec.whole.numbers)
        pairs = np.array(list(spec.pairs()), dtype=np.int64)
        rows = _rows(scores.qcrs.score_pairs(scores.index.join(first), scores.index.join(second), pairs, settings))
        return Artifact({**rows.arrays, **side_starts(inputs, spec.whole)})

    def score(a: TrunkStack, b: TrunkStack, same: bool) -> Columns:
        return _rows(scores.qcrs.score_block(a, b, settings, same=same)).arrays

    return ordered(block_rows(inputs, spec, score))


def join(artifacts: Sequence[Artifact], lost: Sequence[SubBlock]) -> Artifact:
    """The artifact of a block from those of its sub-blocks; pairs of ``lost`` sub-blocks have the rows of `unknown`."""
    pieces = [*(artifact.arrays for artifact in artifacts), *(unknown(list(block.pairs())).arrays for block in lost)]
    rows = {name: np.concatenate([arrays[name] for arrays in pieces]) for name in COLUMNS}
    starts = {name: artifact.arrays[name] for artifact in artifacts[:1] for name in STARTS}
    return ordered(Artifact({**rows, **starts}))


def unknown(pairs: Sequence[tuple[int, int]]) -> Artifact:
    """Rows of pairs that could not be scored: score nan; n, trunks and shift −1."""
    i, j = np.array(pairs, dtype=np.int32).reshape(-1, 2).T
    small, large = np.full(len(pairs), -1, dtype=np.int8), np.full(len(pairs), -1, dtype=np.int32)
    return _rows(scores.qcrs.BlockScores(i, j, np.full(len(pairs), np.nan), small, large, large, small))


def _rows(block: BlockScores) -> Artifact:
    return Artifact({name: np.asarray(getattr(block, name)) for name in COLUMNS})


def items(progress: Progress) -> list[WorkItem]:
    """A work item for every two groups of batches, and for each group with itself."""
    return between_groups(progress, "qcrs", [range(number, number + 1) for number in range(len(progress.groups))])


def scores_all(config: Config) -> bool:
    """Whether a run scores every pair."""
    return config.qcrs.mode == "all"


STAGE = Stage(
    name="qcrs",
    unit="blocks of pairs",
    after=("trunks",),
    parameters=("qcrs",),
    items=items,
    run=run,
    scope="block",
    prepare=prepare,
    wanted=scores_all,
    tile=8,
    sub_blocks=SubBlocks(join, columns_are_shapes=True),
    tables=(
        TableColumns(
            "qcrs",
            (
                Column("i", "int32", "first shape (P)", "shape number"),
                Column("j", "int32", "second shape (Q)", "shape number"),
                Column(
                    "score",
                    "float32",
                    "QCRS, to 7 digits (`selected` has all); 0 when the two have no trunks of one size, nan where it "
                    "was set aside",
                    "score in [0, 1]",
                ),
                Column("n", "int8", "vertices of the two trunks, 0 = none, −1 = set aside (table of errors)", "count"),
                Column("trunk_i", "int32", "the best pair's trunk of i, −1 = none", "trunk number"),
                Column("trunk_j", "int32", "the best pair's trunk of j, −1 = none", "trunk number"),
                Column("shift", "int8", "vertex k of trunk_i corresponds to (shift − k) mod n of trunk_j", "count"),
            ),
            lambda artifact: artifact.arrays,
            "Quick cross-reversibility score of every pair i < j (paper §5.2).",
        ),
    ),
)

"""Quarantine: what hangs or ends its process is found and set aside; all else is done as if it were not there.

Work that failed so is done again in smaller pieces. A batch of shapes is done shape by shape, and the plan is made
again without the culprits: what comes out is, to the byte, what comes out of a collection without them. A block of
pairs is halved again and again, down to the pair, and the search for partners of a batch down to the shape; the block
is joined from what was done, with the lost pairs unknown. Each has a row of the errors. None is kept in the store: the
next run tries it again. Where no piece is deadly, the pieces are joined to what the work would have made.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from pipeline.datasets.collection import Collection, Rejected
from pipeline.plan.code_digest import edited_since_start
from pipeline.plan.progress import Progress, begin
from pipeline.plan.sub_block import SubBlock
from pipeline.plan.work_item import Reference, WorkItem
from pipeline.runtime.events import Note
from pipeline.runtime.execute import Run
from pipeline.runtime.reuse import with_older_results
from pipeline.runtime.worker import Failure
from pipeline.stages.all import STAGES
from pipeline.stages.shape_arrays import join_single
from pipeline.stages.stage import Stage

OF_SHAPES = tuple(stage for stage in STAGES if stage.scope == "batch")
"""The stages of batches of shapes, in order."""

MOST = 128
"""So many parts of blocks may fail at once and be halved. More are no single pair's fault, and are lost as they are."""

Culprits = dict[int, tuple[str, Failure]]
"""Positions of shapes in the collection, with the stage and the failure of each."""


def bring_shapes(progress: Progress, run: Run) -> Progress:
    """Bring the stages of shapes into the store; returns what is known then, without the shapes that were set aside."""
    while True:
        done, culprits = _until_culprits(progress, run)
        if not culprits:
            return done
        collection = without(progress.collection, culprits)
        progress = begin(progress.config, collection, progress.recipes, progress.read)
        names = ", ".join(row.name for row in collection.rejected[-len(culprits) :])
        run.listen(Note(f"set aside, and planned anew without: {names}"))
        run.begin_again()


def without(collection: Collection, culprits: Culprits) -> Collection:
    """The collection without these items, which are among its rejected ones."""
    rows = []
    for position, (stage, failure) in sorted(culprits.items()):
        item, reason = collection.items[position], failure.reason or "quarantined"
        rows.append(Rejected(item.name, item.source, reason, failure.message, stage, failure.type, failure.attempts))
    kept = tuple(item for position, item in enumerate(collection.items) if position not in culprits)
    return replace(collection, items=kept, rejected=(*collection.rejected, *rows))


def _until_culprits(progress: Progress, run: Run) -> tuple[Progress, Culprits]:
    """Run the stages of shapes until one has culprits."""
    for stage in OF_SHAPES:
        work = stage.items(progress)
        run.stage(stage, work)
        progress = progress.with_work(stage.name, work, frozenset(run.done))
        culprits: Culprits = {}
        for item in work:
            failure = run.failed.get(item.reference)
            if failure is None or not failure.deadly:
                continue
            if len(item.members) == 1:
                culprits[item.members[0]] = (stage.name, failure)
            else:
                culprits |= _among(progress, stage, item, run)
        if culprits:
            return progress, culprits
        progress = replace(progress, done=frozenset(run.done))  # a batch may be joined from its shapes
    return progress, {}


def _among(progress: Progress, stage: Stage, batch: WorkItem, run: Run) -> Culprits:
    """Which members of a batch do alone what the batch did; where all do well, they are joined to the batch."""
    alone = {position: _work_alone(progress.alone(position), stage) for position in batch.members}
    culprits: Culprits = {}
    left = dict(alone)
    for name in dict.fromkeys((OF_SHAPES[0].name, stage.name)):
        failures = run.probe([work[name] for work in left.values()])
        for position, work in list(left.items()):
            failure = failures.get(work[name].reference)
            if failure is not None:
                del left[position]
                if failure.deadly:
                    culprits[position] = (name, failure)
    if len(left) == len(alone) and not edited_since_start(stage.module):
        parts = [work[stage.name] for work in alone.values()]
        run.adopt(batch, batch, parts, join_single([run.store.get(*part.reference) for part in parts]))
    return culprits


def _work_alone(progress: Progress, last: Stage) -> dict[str, WorkItem]:
    """The work of a single shape in the stages of shapes up to ``last``, by stage."""
    work = {}
    for stage in OF_SHAPES:
        (work[stage.name],) = stage.items(progress)
        if stage is last:
            break
        progress = progress.with_work(stage.name, [work[stage.name]], progress.done)
    return work


def bring_blocks(progress: Progress, stage: Stage, run: Run) -> tuple[list[WorkItem], list[WorkItem]]:
    """Bring the work of a stage of blocks into the store.

    Returns its work items, in which those are replaced of which parts were lost, and the lost parts.
    """
    assert stage.sub_blocks is not None
    work = list(stage.items(progress))
    run.stage(stage, with_older_results(run.store, work))
    failures = dict(run.failed)
    deadly = [item for item in work if _deadly(failures.get(item.reference))]
    if not deadly or edited_since_start(stage.module):
        return work, []
    trials = [_Trial(item, stage.sub_blocks.whole(progress, item), item) for item in deadly]
    broken = {item.reference: _Broken() for item in deadly}
    while trials:
        failed = {trial.item.reference: failures.get(trial.item.reference) for trial in trials}
        few = sum(failure is not None for failure in failed.values()) <= MOST
        smaller: list[_Trial] = []
        for trial in trials:
            failure = failed[trial.item.reference]
            halves = trial.part.halves() if few and _deadly(failure) else []
            if failure is None:
                broken[trial.block.reference].done.append(trial.item)
            elif halves:
                smaller += [_Trial(trial.block, half, _item(progress, stage, trial.block, half)) for half in halves]
            else:
                broken[trial.block.reference].lost.append((trial, failure))
        trials = smaller
        failures = run.probe([trial.item for trial in trials])
    return _joined(progress, stage, work, broken, run)


@dataclass(frozen=True)
class _Trial:
    """A part of a block, tried by itself."""

    block: WorkItem
    part: SubBlock
    item: WorkItem


@dataclass
class _Broken:
    """A block that failed as a whole: its parts that were done, and those that were lost."""

    done: list[WorkItem] = field(default_factory=list)
    lost: list[tuple[_Trial, Failure]] = field(default_factory=list)


def _item(progress: Progress, stage: Stage, block: WorkItem, part: SubBlock) -> WorkItem:
    """The work item of a part of a block; of its rows and columns it has the members."""
    assert stage.sub_blocks is not None
    recipe = progress.recipes[stage.name]
    members = stage.sub_blocks.members(progress, block, part)
    return recipe.item(recipe.parts(block.parts.inputs, part), block.sources, spec=part, members=members)


def _without(progress: Progress, block: WorkItem, lost: Sequence[SubBlock]) -> WorkItem:
    """A block without some parts: nothing does it at once, it is joined from the others."""
    parts = progress.recipes[block.stage].parts(block.parts.inputs, lost)
    return replace(block, parts=parts, spec=tuple(lost))


def _joined(
    progress: Progress, stage: Stage, work: list[WorkItem], broken: dict[Reference, _Broken], run: Run
) -> tuple[list[WorkItem], list[WorkItem]]:
    """`bring_blocks` of broken blocks."""
    assert stage.sub_blocks is not None
    lost: list[WorkItem] = []
    joined = []
    for block in work:
        pieces = broken.get(block.reference)
        if pieces is None:
            joined.append(block)
            continue
        parts = [trial.part for trial, _ in pieces.lost]
        item = _without(progress, block, parts) if parts else block
        artifacts = [run.store.get(*part.reference) for part in pieces.done]
        run.adopt(block, item, pieces.done, stage.sub_blocks.join(artifacts, parts))
        if parts:  # the next run tries the block anew, and then needs its parts
            run.done |= {part.reference for part in pieces.done}
        run.failed |= {trial.item.reference: failure for trial, failure in pieces.lost}
        joined.append(item)
        lost += [trial.item for trial, _ in pieces.lost]
    if lost:
        run.listen(Note(f"set aside: {', '.join(_names(progress, progress.members(item)) for item in lost)}"))
    return joined, lost


def _names(progress: Progress, members: Sequence[int]) -> str:
    if len(members) > 2:
        return f"{len(members)} shapes"
    return " × ".join(progress.items[position].name for position in members)


def _deadly(failure: Failure | None) -> bool:
    return failure is not None and failure.deadly

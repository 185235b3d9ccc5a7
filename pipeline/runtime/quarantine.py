"""Quarantine: what hangs or ends its process is found and set aside; all else is done as if it were not there.

Work that failed so is done again in smaller pieces. A batch of shapes is done shape by shape, and the plan is made
again without the culprits: what comes out is, to the byte, what comes out of a collection without them. A block of
pairs is halved again and again, down to the pair, and the search for partners of a batch down to the shape; the block
is joined from what was done, with the lost pairs unknown. Each has a row of the errors. None is kept in the store: the
next run tries it again. Where no piece is deadly, the pieces are joined to what the work would have made.
"""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from pipeline.datasets.collection import Collection, Rejected
from pipeline.plan.code_digest import edited_since_start
from pipeline.plan.part import Part
from pipeline.plan.plan import Pair, Plan, WorkItem, make_plan, plan_alone, plan_part, plan_without, whole_part
from pipeline.runtime.events import Note
from pipeline.runtime.execute import Run
from pipeline.runtime.worker import Failure
from pipeline.stages.registry import BY_NAME

OF_SHAPES = ("ingest", "reversibility", "trunks")
"""The stages of batches of shapes, in order."""

MOST = 128
"""So many parts of blocks may fail at once and be halved. More are no single pair's fault, and are lost as they are."""

Culprits = dict[int, tuple[str, Failure]]
"""Positions of shapes in the collection, with the stage and the failure of each."""


def bring_shapes(plan: Plan, collection: Collection, run: Run) -> tuple[Plan, Collection]:
    """Bring the stages of shapes into the store; returns plan and collection without the shapes that were set aside."""
    while culprits := _first_culprits(plan, run):
        collection = without(collection, culprits)
        plan = make_plan(plan.config, collection)
        names = ", ".join(row.name for row in collection.rejected[-len(culprits) :])
        run.listen(Note(f"set aside, and planned anew without: {names}"))
        run.begin_again()
    return plan, collection


def without(collection: Collection, culprits: Culprits) -> Collection:
    """The collection without these items, which are among its rejected ones."""
    rows = []
    for position, (stage, failure) in sorted(culprits.items()):
        item, reason = collection.items[position], failure.reason or "quarantined"
        rows.append(Rejected(item.name, item.source, reason, failure.message, stage, failure.type, failure.attempts))
    kept = tuple(item for position, item in enumerate(collection.items) if position not in culprits)
    return replace(collection, items=kept, rejected=(*collection.rejected, *rows))


def _first_culprits(plan: Plan, run: Run) -> Culprits:
    """Run the stages of shapes until one has culprits."""
    for stage in OF_SHAPES:
        work = getattr(plan, stage)
        run.stage(stage, work)
        culprits: Culprits = {}
        for item in work:
            failure = run.failed.get(item.reference)
            if failure is None or not failure.deadly:
                continue
            if len(item.members) == 1:
                culprits[item.members[0]] = (stage, failure)
            elif found := _among(plan, item, run):
                culprits |= found
        if culprits:
            return culprits
    return {}


def _among(plan: Plan, batch: WorkItem, run: Run) -> Culprits:
    """Which members of a batch do alone what the batch did; where all do well, they are joined to the batch."""
    alone = {position: plan_alone(plan, position) for position in batch.members}
    culprits: Culprits = {}
    left = dict(alone)
    for name in dict.fromkeys(("ingest", batch.stage)):
        failures = run.probe([work[name] for work in left.values()])
        for position, work in list(left.items()):
            failure = failures.get(work[name].reference)
            if failure is not None:
                del left[position]
                if failure.deadly:
                    culprits[position] = (name, failure)
    if len(left) == len(alone) and not edited_since_start(BY_NAME[batch.stage].module):
        from pipeline.stages.items import join_single  # here: what joins is seldom needed

        parts = [work[batch.stage] for work in alone.values()]
        run.adopt(batch, batch, parts, join_single([run.store.get(*part.reference) for part in parts]))
    return culprits


def bring_scores(plan: Plan, run: Run) -> tuple[Plan, tuple[WorkItem, ...]]:
    """Bring the blocks of pairs, or the searches for partners, into the store.

    Returns the plan, in which those are replaced of which parts were lost, and the lost parts.
    """
    stage = "qcrs" if plan.pairs is None else "partners"
    run.stage(stage, tuple(plan.qcrs.values()))
    failures = dict(run.failed)
    deadly = {place: item for place, item in plan.qcrs.items() if _deadly(failures.get(item.reference))}
    if not deadly or edited_since_start(BY_NAME[stage].module):
        return plan, ()
    trials = [_Trial(place, whole_part(plan, place), item) for place, item in deadly.items()]
    broken = {place: _Broken() for place in deadly}
    while trials:
        failed = {one.item.reference: failures.get(one.item.reference) for one in trials}
        few = sum(failure is not None for failure in failed.values()) <= MOST
        smaller: list[_Trial] = []
        for one in trials:
            failure = failed[one.item.reference]
            halves = one.part.halves() if few and _deadly(failure) else []
            if failure is None:
                broken[one.place].done.append(one.item)
            elif halves:
                smaller += [_Trial(one.place, half, plan_part(plan, one.place, half)) for half in halves]
            else:
                broken[one.place].lost.append((one, failure))
        trials = smaller
        failures = run.probe([one.item for one in trials])
    return _joined(plan, broken, run)


@dataclass(frozen=True)
class _Trial:
    """A part of a block, tried by itself."""

    place: Pair
    part: Part
    item: WorkItem


@dataclass
class _Broken:
    """A block that failed as a whole: its parts that were done, and those that were lost."""

    done: list[WorkItem] = field(default_factory=list)
    lost: list[tuple[_Trial, Failure]] = field(default_factory=list)


def _joined(plan: Plan, broken: dict[Pair, _Broken], run: Run) -> tuple[Plan, tuple[WorkItem, ...]]:
    """`bring_scores` of broken blocks."""
    qcrs = dict(plan.qcrs)
    lost: list[WorkItem] = []
    for place, found in broken.items():
        whole, without = plan.qcrs[place], [one.part for one, _ in found.lost]
        made = plan_without(plan, place, without) if without else whole
        join = importlib.import_module(BY_NAME[whole.stage].module).join
        artifacts = [run.store.get(*part.reference) for part in found.done]
        run.adopt(whole, made, found.done, join(artifacts, without))
        if without:  # the next run tries the block anew, and then needs its parts
            run.done |= {part.reference for part in found.done}
        run.failed |= {one.item.reference: failure for one, failure in found.lost}
        qcrs[place] = made
        lost += [one.item for one, _ in found.lost]
    if lost:
        run.listen(Note(f"set aside: {', '.join(_names(plan, item.members) for item in lost)}"))
    return replace(plan, qcrs=qcrs), tuple(lost)


def _names(plan: Plan, members: Sequence[int]) -> str:
    if len(members) > 2:
        return f"{len(members)} shapes"
    return " × ".join(plan.items[position].name for position in members)


def _deadly(failure: Failure | None) -> bool:
    return failure is not None and failure.deadly

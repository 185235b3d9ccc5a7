"""Quarantine: shapes that hang or end the process of their batch are found and set aside; the others of it are done.

The plan is made again without them: what comes out is, to the byte, what comes out of a collection without them, with a
row of the errors for each. Nothing of it is kept in the store: the next run tries them again.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from pipeline.datasets import Collection, Rejected
from pipeline.events import Note
from pipeline.execute import Run
from pipeline.perform import Failure
from pipeline.plan import Plan, make_plan, plan_alone

OF_SHAPES = ("ingest", "reversibility", "trunks")
"""The stages of batches of shapes, in order."""

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
            else:
                culprits |= _among(plan, stage, item.members, run)
        if culprits:
            return culprits
    return {}


def _among(plan: Plan, stage: str, members: Iterable[int], run: Run) -> Culprits:
    """Which members of a batch do alone what the batch did; none where it takes them together."""
    alone = {position: plan_alone(plan, position) for position in members}
    culprits: Culprits = {}
    for name in ("ingest", stage) if stage != "ingest" else ("ingest",):
        failures = run.probe([work[name] for work in alone.values()])
        for position, work in list(alone.items()):
            failure = failures.get(work[name].reference)
            if failure is not None:
                del alone[position]
                if failure.deadly:
                    culprits[position] = (name, failure)
    return culprits

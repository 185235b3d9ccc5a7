"""Reuse: a grown collection is cut into other blocks and parts, of which older artifacts have most (ours)."""

from __future__ import annotations

from collections.abc import Sequence

from pipeline.plan.sub_block import Sides
from pipeline.plan.work_item import WorkItem
from pipeline.runtime.reuse_blocks import with_older_blocks
from pipeline.runtime.reuse_searches import with_older_searches
from pipeline.stages.search_spec import Search
from pipeline.store.store import Store


def with_older_results(store: Store, work: Sequence[WorkItem]) -> list[WorkItem]:
    """The work items of a stage, in which those that the store lacks read what older results have of them.

    Their keys are the same: a score does not depend on where it is found.
    """
    spec = work[0].spec if work else None
    if isinstance(spec, Sides):
        return with_older_blocks(store, work)
    return with_older_searches(store, work) if isinstance(spec, Search) else list(work)

"""The exact construction: both trunks of a plan partitioned, detail given back, pieces cut (theory §8)."""

from __future__ import annotations

from riot.construct.draft import draft_plan
from riot.construct.plan import Plan
from riot.parameters import ConstructParameters
from riot.transform import Transform


def construct_plan(plan: Plan, parameters: ConstructParameters) -> Transform:
    """Partition both trunks and cut the pieces; ConstructionError with the reason if a partition fails.

    `riot.construct.draft.draft_plan` keeps the partitions, to cut the pieces again with pins.
    """
    return draft_plan(plan, parameters).transform()

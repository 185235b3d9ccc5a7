"""The motion of one certified construction: how its pieces swing, without collision (paper Fig. 11; planner ours)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from pipeline.plan.progress import Progress
from pipeline.plan.work_item import WorkItem
from pipeline.stages.choose import chosen_certified
from pipeline.stages.shape_arrays import ErrorRow, attempt
from pipeline.stages.stage import Column, Stage, TableColumns
from pipeline.store.artifact import Artifact
from riot import motion, transform


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: None) -> Artifact:
    """A certified construction → a document: the ``.riot`` text with its motion, and the motion's row."""
    (constructed,), (settings,) = inputs, parameters
    puzzle = transform.riot_file.from_json(constructed.document["riot"])
    errors: list[ErrorRow] = []
    plan = attempt(0, lambda: motion.planner.plan_motion(puzzle, settings), errors)
    if plan is None:
        return Artifact({}, {"errors": errors})
    row = {
        "swings_flat": plan.flat,
        "lifted_hinges": list(plan.lifted),
        "open_hinge": plan.open_hinge,
        "motion_search": plan.search,
    }
    return Artifact({}, {"riot": transform.riot_file.to_json(replace(puzzle, plan=plan)), **row})


def items(progress: Progress) -> list[WorkItem]:
    """A work item for each chosen construction that is certified, in order."""
    return [progress.recipes["motion"].after(item) for item in chosen_certified(progress)]


def _row(artifact: Artifact) -> Mapping[str, Any]:
    return {name: value for name, value in artifact.document.items() if name != "riot"}


STAGE = Stage(
    name="motion",
    unit="certified transforms",
    after=("construct", "choose"),
    parameters=("motion",),
    items=items,
    run=run,
    scope="pair",
    known_after="construct",
    bundle=16,
    tables=(
        TableColumns(
            "transforms",
            (
                Column("swings_flat", "bool", "whether all pieces swing in one plane from P to Q, null = not planned"),
                Column(
                    "lifted_hinges",
                    "list<int8>",
                    "telescopic hinges: the pieces after one move a plane higher",
                    "hinge",
                ),
                Column(
                    "open_hinge",
                    "int8",
                    "the hinge that is open: hinge j is before piece j, null = not planned",
                    "hinge",
                ),
                Column(
                    "motion_search",
                    "string",
                    "which search found the motion, of several the last; null = not planned",
                ),
            ),
            _row,
        ),
    ),
)

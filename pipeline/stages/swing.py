"""The motions of all certified constructions, where only those that swing flat may be chosen (``select.flat``; ours).

The stage ``motion`` plans those of the chosen again, in less than a tenth of a second each: a run without this wish
plans no others.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pipeline.plan.progress import Progress
from pipeline.plan.work_item import WorkItem
from pipeline.stages import motion
from pipeline.stages.construct import certified
from pipeline.stages.stage import Stage
from pipeline.store.artifact import Artifact


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: None) -> Artifact:
    """A certified construction → its motion, as the stage ``motion``."""
    return motion.run(inputs, parameters, spec)


def items(progress: Progress) -> list[WorkItem]:
    """A work item for each certified construction, in order."""
    return [progress.recipes["swing"].after(item) for item in certified(progress)]


STAGE = Stage(
    name="swing",
    unit="certified transforms",
    after=("construct",),
    parameters=("motion",),
    items=items,
    run=run,
    scope="pair",
    known_after="construct",
    wanted=lambda config: config.select.flat,
    at_most=lambda config: config.select.constructed,
    bundle=16,
)

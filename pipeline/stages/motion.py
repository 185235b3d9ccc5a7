"""The motion of one certified construction: its ``.riot`` text with the plan, and what the tables say of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from pipeline.stages.items import ErrorRow, attempt
from pipeline.store.artifact import Artifact
from riot.motion.planner import plan_motion
from riot.transform.motion import Motion
from riot.transform.riot_file import from_json, to_json


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: None) -> Artifact:
    """A certified construction → a document: the ``.riot`` text with its motion, and the motion's row."""
    (made,), (settings,) = inputs, parameters
    transform = from_json(made.document["riot"])
    errors: list[ErrorRow] = []
    motion = attempt(0, lambda: plan_motion(transform, settings), errors)
    if motion is None:
        return Artifact({}, {"errors": errors})
    return Artifact({}, {"riot": to_json(replace(transform, plan=motion)), **_row(motion)})


def _row(motion: Motion) -> dict[str, Any]:
    return {
        "swings_flat": motion.flat,
        "lifted_hinges": list(motion.lifted),
        "open_hinge": motion.open_hinge,
        "motion_search": motion.search,
    }


COLUMNS = ("swings_flat", "lifted_hinges", "open_hinge", "motion_search")
"""What `transforms` has of it."""

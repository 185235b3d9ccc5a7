"""Elastic modes of one shape that is to be constructed (theory §12; ours)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.config.schema import Config
from pipeline.plan.progress import Progress
from pipeline.plan.work_item import WorkItem
from pipeline.stages.planning import of_shapes
from pipeline.stages.shape_arrays import ErrorRow, attempt, expect_shape
from pipeline.stages.shortlist import shortlisted
from pipeline.stages.stage import Stage
from pipeline.store.artifact import Artifact
from riot import geometry
from riot.geometry.shape import Shape

if TYPE_CHECKING:
    from riot.geometry.modes import Modes


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: int) -> Artifact:
    """The shape at ``spec`` of a batch → its modes (see `unpack_modes`); no arrays where it has none."""
    (batch,), (count, straight) = inputs, parameters
    errors: list[ErrorRow] = []
    shape = expect_shape(batch, spec)
    found = attempt(0, lambda: geometry.modes.modes(shape, count, straight), errors)
    if found is None:
        return Artifact({}, {"errors": errors})
    elements, sides = found.elements, found.sides
    arrays = {
        "nodes": elements.nodes,
        "triangles": elements.triangles,
        "boundary": elements.boundary,
        "eigenvalues": found.eigenvalues,
        "vectors": found.vectors,
        "ends": sides.ends,
        "joints": sides.joints,
    }
    return Artifact(arrays, {"straight": straight, "errors": errors})


def unpack_modes(artifact: Artifact, shape: Shape) -> Modes | None:
    """The modes of ``shape`` that `run` packed; None where it has none."""
    if not artifact.arrays:
        return None
    # Copies: compiled kernels would compile a second time for read-only arrays.
    arrays = {name: np.array(values) for name, values in artifact.arrays.items()}
    elements = geometry.elements.Elements(arrays["nodes"], arrays["triangles"], arrays["boundary"])
    return geometry.modes.Modes(
        shape,
        elements,
        arrays["eigenvalues"],
        arrays["vectors"],
        np.ones(len(elements.triangles)),
        artifact.document["straight"],
        geometry.sides.Sides(arrays["ends"], arrays["joints"]),
    )


def bends(config: Config) -> bool:
    """Whether a run bends shapes before they are cut."""
    return config.bend.method == "elastic"


def items(progress: Progress) -> list[WorkItem]:
    """A work item for each shape of the shortlisted pairs, by position."""
    refined = progress.finished("refine")
    members = (member for number in shortlisted(progress) for member in refined[number].members)
    return of_shapes(progress, "modes", members)


STAGE = Stage(
    name="modes",
    unit="shapes",
    after=("shortlist",),
    parameters=("bend.modes", "bend.straight"),
    items=items,
    run=run,
    scope="shape",
    known_after="shortlist",
    wanted=bends,
    at_most=lambda config: 2 * config.select.constructed,
    bundle=16,
)

"""Plan stages that have a work item for each work item of another stage, or for every two."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from pipeline.datasets.colours import may_be_coloured
from pipeline.plan.progress import Progress
from pipeline.plan.sub_block import Sides
from pipeline.plan.work_item import WorkItem
from pipeline.stages.ingest import shape_key


def after_each(progress: Progress, stage: str, earlier: str) -> list[WorkItem]:
    """A work item for each one of the stage ``earlier``, done or not, that reads the artifact of that one alone."""
    recipe = progress.recipes[stage]
    return [recipe.after(item) for item in progress.work[earlier]]


def between_groups(progress: Progress, stage: str, spans: Sequence[range]) -> list[WorkItem]:
    """A work item for every two of these spans of groups of batches of trunks, and each with itself.

    Spans are of numbers of groups; ``spec`` has the `Sides` of a work item.
    """
    recipe, trunks = progress.recipes[stage], progress.work["trunks"]
    batches = [[trunks[number] for group in span for number in progress.groups[group]] for span in spans]
    sizes = [len(progress.of_span(span)) for span in spans]
    blocks = []
    for a, rows in enumerate(batches):
        for b in range(a, len(batches)):
            columns = [] if a == b else batches[b]
            both, sides = [*rows, *columns], Sides(len(rows), len(columns))
            m, n = sizes[a], sizes[b]
            blocks.append(
                recipe.item(
                    recipe.parts([item.key for item in both], sides),
                    [item.reference for item in both],
                    spec=sides,
                    block=(a, b),
                    pairs=m * (m - 1) // 2 if a == b else m * n,
                )
            )
    return blocks


def of_shapes(progress: Progress, stage: str, positions: Iterable[int]) -> list[WorkItem]:
    """A work item for each shape at ``positions``, by position; ``spec`` is its index in its batch.

    Its key depends on the shape and not on its batch, so that it stays if the batch changes.
    """
    recipe, ingest = progress.recipes[stage], progress.work["ingest"]
    work = []
    for position in sorted(set(positions)):
        batch, index = progress.locate(position)
        parts = recipe.parts([shape_key(progress, position)])
        work.append(recipe.item(parts, [ingest[batch].reference], spec=index, members=[position]))
    return work


def after_motion(progress: Progress, stage: str, motion: WorkItem) -> WorkItem:
    """The work item of ``stage`` that reads a motion, and those pictures of its pair that may have colours."""
    recipe = progress.recipes[stage]
    pictures = [progress.items[position] for position in motion.members]
    of_folder = progress.config.dataset.kind == "folder"
    spec = tuple(item if of_folder and may_be_coloured(item) else None for item in pictures)
    if spec == (None, None):
        return recipe.after(motion)
    inputs = [motion.key, *(item.digest for item in spec if item is not None)]
    parts = recipe.parts(inputs, [item is not None for item in spec])
    return recipe.item(parts, [motion.reference], spec=spec, members=motion.members)

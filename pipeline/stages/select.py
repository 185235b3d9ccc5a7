"""Selection: which pairs go on to CRS, by policy, block by block (paper §5.3; other policies and breadth are ours)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Any

import numpy as np

from pipeline.plan.progress import Progress
from pipeline.plan.work_item import WorkItem
from pipeline.stages.candidates import Shapes, Starts, Surprise, candidates, qcrs_of, read_rows
from pipeline.stages.collected import Collected
from pipeline.stages.policies import (
    Block,
    Chosen,
    SelectionLimits,
    best_of_classes,
    first_pool,
    select_best,
    select_global,
)
from pipeline.stages.pool import Rows, fill_pool
from pipeline.stages.preselect import last_level
from pipeline.stages.qualities import doubtful
from pipeline.stages.stage import Stage
from pipeline.stages.wishes import WishedShapes, wished_shapes
from pipeline.store.artifact import Artifact
from pipeline.store.keys import digest_text


@dataclass(frozen=True)
class Selecting:
    """What selection reads of the collection.

    ``classes`` are by position, ``starts`` the positions of the batches' first shapes. The inputs are, in this order,
    ``parts`` of the pairs, or else scores of ``blocks`` and of the blocks ``rare``, by the positions of their first
    shapes on both sides, reversibility of ``rated`` and the shapes ``read``, if those in doubt are left out, by numbers
    of batches, and, if it is ``described``, the collection. ``wishes`` are the pairs that the user wants.

    With parts the blocks come last, and are read only if the parts have too few pairs.
    """

    classes: tuple[str, ...]
    starts: tuple[int, ...]
    blocks: tuple[tuple[int, int], ...]
    rare: tuple[tuple[int, int], ...]
    rated: tuple[int, ...]
    described: bool
    wishes: WishedShapes
    read: tuple[int, ...] = ()
    parts: tuple[tuple[int, int], ...] = ()


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: Selecting) -> Artifact:
    """The inputs that `Selecting` lists → ``pairs`` (p, 2) int64, best first, ``score`` (p,): QCRS.

    Only one input is in memory at a time: there are as many as blocks.
    """
    settings, mirrored, _ = parameters
    lengths = [len(spec.parts or spec.blocks), len(spec.rare), len(spec.rated), len(spec.read), int(spec.described)]
    ends = np.cumsum(lengths).tolist()
    scored, rare, rated, read, things = (inputs[end - length : end] for end, length in zip(ends, lengths, strict=True))
    collected = Collected.of(things[0].arrays if spec.described else {}, len(spec.classes))
    batches = {spec.starts[number]: batch for number, batch in zip(spec.read, read, strict=True)}
    clear = ~doubtful(batches, len(spec.classes))
    shapes = Shapes.of(spec.classes, spec.wishes).only(clear)
    surprise = None
    if settings.min_surprise > 0:
        surprise = Surprise(collected, np.arange(len(spec.classes)), settings.min_surprise, mirrored)

    def rows(starts: Starts, artifacts: Sequence[Artifact]) -> Iterator[Rows]:
        return candidates(starts, artifacts, shapes, settings.pieces, surprise)

    def blocks(size: int) -> tuple[Iterable[Block], bool]:
        if not spec.parts:
            return (block[:3] for block in rows(spec.blocks, scored)), False
        if size == first_pool(settings.selected):
            parts = (part[:3] for part in read_rows(spec.parts, scored))
            return parts, any(part.document["cut"] for part in scored)
        return (block[:3] for block in rows(spec.blocks, inputs[ends[-1] :])), False

    if settings.policy == "varied":
        of_parts, of_blocks = read_rows(spec.parts, scored), chain(rows(spec.blocks, scored), rows(spec.rare, rare))
        every = of_parts if spec.parts else of_blocks
        pairs = fill_pool(every, collected.cluster, shapes.label, collected.perimeter, settings.selected)
        score = qcrs_of(pairs[:, 0], pairs[:, 1], spec.parts or spec.blocks, scored)
        order = np.lexsort((pairs[:, 1], pairs[:, 0], -score))
        chosen = Chosen(pairs[order], score[order])
    elif settings.policy == "paper":
        ratings = np.full(len(spec.classes), np.nan)
        for number, batch in zip(spec.rated, rated, strict=True):
            start = spec.starts[number]
            ratings[start : start + len(batch.arrays["score"])] = batch.arrays["score"]
        ratings[~clear] = np.nan
        shapes = shapes.only(best_of_classes(spec.classes, ratings))
        chosen = select_best((block[:3] for block in rows(spec.blocks, scored)), settings.selected)
    else:
        widened = (settings.top, settings.per_class_pair, settings.per_shape)
        limits = SelectionLimits(*(settings.breadth_of_policy * most for most in widened))
        chosen = select_global(blocks, shapes.label, limits)
    return Artifact({"pairs": chosen.pairs, "score": chosen.score})


def items(progress: Progress) -> list[WorkItem]:
    """One work item over the parts of the pairs, or, in a small collection, over the blocks that are done.

    Unlike the other keys, its key holds the classes in order. With ``qcrs.mode=topk`` it is over the collected pairs,
    done or not, which number shapes by position, as the first batch does. The selection equals that from all pairs
    unless the limits and classes need a pair that is beyond the k best of both of its shapes.
    """
    if "pairs" in progress.work:
        blocks = [(item, (0, 0)) for item in progress.work["pairs"] if progress.batches]
    else:
        blocks = _starts(progress, "qcrs")
    parts = last_level(progress)
    varied = progress.config.select.policy == "varied"
    rare = [] if parts else _starts(progress, "qcrs_rare")
    ratings = progress.work["reversibility"] if not varied else ()
    rated = [number for number, item in enumerate(ratings) if item.reference in progress.done]
    things = progress.finished("near_duplicates") if varied else []
    dropping = progress.config.shape.doubtful == "drop"
    ingest = progress.work["ingest"] if dropping else ()
    read = [number for number, item in enumerate(ingest) if item.reference in progress.done]
    spec = Selecting(
        progress.classes,
        tuple(batch.start for batch in progress.batches),
        tuple(start for _, start in blocks),
        tuple(start for _, start in rare),
        tuple(rated),
        bool(things),
        wished_shapes(progress.config.select, progress.items),
        tuple(read),
        tuple(start for _, start in parts),
    )
    first = [item for item, _ in (*(parts or blocks), *rare)]
    needed = [*first, *(ratings[number] for number in rated), *(ingest[number] for number in read), *things]
    sources = [*needed, *(item for item, _ in blocks if parts)]
    recipe = progress.recipes["select"]
    # A digest instead of the spec keeps the classes out of the manifest.
    parts_of_key = recipe.parts([item.key for item in needed], digest_text(repr(spec)))
    return [recipe.item(parts_of_key, [item.reference for item in sources], spec=spec)]


def _starts(progress: Progress, stage: str) -> list[tuple[WorkItem, tuple[int, int]]]:
    """The blocks of a stage that are done, and the positions of their first shapes on both sides."""
    return [
        (item, (progress.of_side(stage, item.block[0]).start, progress.of_side(stage, item.block[1]).start))
        for item in progress.finished(stage)
        if item.block is not None
    ]


def selected(progress: Progress) -> Chosen:
    """The pairs that a finished selection chose, best first, with their scores; none if it failed."""
    for item in progress.finished("select"):
        arrays = progress.read(item).arrays
        return Chosen(np.array(arrays["pairs"]), np.array(arrays["score"]))
    return Chosen(np.empty((0, 2), dtype=np.int64), np.empty(0))


STAGE = Stage(
    name="select",
    unit="selection",
    after=("ingest", "qcrs", "qcrs_rare", "preselect", "pairs", "reversibility", "near_duplicates"),
    parameters=("select", "likeness.mirrored", "shape.doubtful"),
    items=items,
    run=run,
    scope="collection",
    here=True,
)

"""Selection: which pairs go on to CRS, by policy, block by block (paper §5.3; other policies and breadth are ours)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from typing import TYPE_CHECKING, Any

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
from riot.types import BoolArray

if TYPE_CHECKING:
    from pipeline.config.selection import SelectConfig


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


@dataclass(frozen=True, eq=False)
class Given:
    """The inputs of a selection by what they are, and which shapes may be selected: the ``clear`` of ``shapes``.

    ``scored`` are the parts, or else the blocks; ``blocks`` these in either case.
    """

    spec: Selecting
    scored: Sequence[Artifact]
    rare: Sequence[Artifact]
    rated: Sequence[Artifact]
    blocks: Sequence[Artifact]
    collected: Collected
    clear: BoolArray
    shapes: Shapes
    pieces: Sequence[int]
    surprise: Surprise | None

    @classmethod
    def of(cls, inputs: Sequence[Artifact], settings: SelectConfig, mirrored: bool, spec: Selecting) -> Given:
        """Tell the inputs apart; of the scores none is read yet."""
        lengths = [len(spec.parts or spec.blocks), len(spec.rare), len(spec.rated), len(spec.read), int(spec.described)]
        ends = np.cumsum(lengths).tolist()
        scored, rare, rated, read, things = (
            inputs[end - length : end] for end, length in zip(ends, lengths, strict=True)
        )
        count = len(spec.classes)
        collected = Collected.of(things[0].arrays if spec.described else {}, count)
        batches = {spec.starts[number]: batch for number, batch in zip(spec.read, read, strict=True)}
        clear = ~doubtful(batches, count)
        surprise = None
        if settings.min_surprise > 0:
            surprise = Surprise(collected, np.arange(count), settings.min_surprise, mirrored)
        shapes = Shapes.of(spec.classes, spec.wishes).only(clear)
        blocks = inputs[ends[-1] :] if spec.parts else scored
        return cls(spec, scored, rare, rated, blocks, collected, clear, shapes, settings.pieces, surprise)

    def rows(self, starts: Starts, artifacts: Sequence[Artifact]) -> Iterator[Rows]:
        """The pairs of some blocks that may be selected."""
        return candidates(starts, artifacts, self.shapes, self.pieces, self.surprise)


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: Selecting) -> Artifact:
    """The inputs that `Selecting` lists → ``pairs`` (p, 2) int64, best first, ``score`` (p,): QCRS.

    Only one input is in memory at a time: there are as many as blocks.
    """
    settings, mirrored, _ = parameters
    policies = {"varied": varied, "paper": best_reversible, "global": least_deformed}
    chosen = policies[settings.policy](Given.of(inputs, settings, mirrored, spec), settings)
    return Artifact({"pairs": chosen.pairs, "score": chosen.score})


def varied(given: Given, settings: SelectConfig) -> Chosen:
    """The best pairs of many different things, over every n of their trunks."""
    spec, collected = given.spec, given.collected
    of_blocks = chain(given.rows(spec.blocks, given.scored), given.rows(spec.rare, given.rare))
    every = read_rows(spec.parts, given.scored) if spec.parts else of_blocks
    pairs = fill_pool(every, collected.cluster, given.shapes.label, collected.perimeter, settings.selected)
    score = qcrs_of(pairs[:, 0], pairs[:, 1], spec.parts or spec.blocks, given.scored)
    order = np.lexsort((pairs[:, 1], pairs[:, 0], -score))
    return Chosen(pairs[order], score[order])


def best_reversible(given: Given, settings: SelectConfig) -> Chosen:
    """The pairs among the shape of best reversibility of each class (policy paper: paper §5.3)."""
    spec = given.spec
    ratings = np.full(len(spec.classes), np.nan)
    for number, batch in zip(spec.rated, given.rated, strict=True):
        start = spec.starts[number]
        ratings[start : start + len(batch.arrays["score"])] = batch.arrays["score"]
    ratings[~given.clear] = np.nan
    among = replace(given, shapes=given.shapes.only(best_of_classes(spec.classes, ratings)))
    return select_best((block[:3] for block in among.rows(spec.blocks, given.scored)), settings.selected)


def least_deformed(given: Given, settings: SelectConfig) -> Chosen:
    """The best pairs of different classes (policy global); blocks are read only if the parts have too few pairs."""
    spec = given.spec

    def blocks(size: int) -> tuple[Iterable[Block], bool]:
        if spec.parts and size == first_pool(settings.selected):
            parts = (part[:3] for part in read_rows(spec.parts, given.scored))
            return parts, any(part.document["cut"] for part in given.scored)
        return (block[:3] for block in given.rows(spec.blocks, given.blocks)), False

    widened = (settings.top, settings.per_class_pair, settings.per_shape)
    limits = SelectionLimits(*(settings.breadth_of_policy * most for most in widened))
    return select_global(blocks, given.shapes.label, limits)


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

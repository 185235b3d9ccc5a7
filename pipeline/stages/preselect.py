"""Preselection: of the pairs of neighbouring blocks, those that the selection may take, level by level (ours).

The parts are a tree. A part of the first level has the best pairs of the blocks between two spans of groups, one of a
higher level the best of its parts; the selection reads the last. Only a bounded number of rows is in memory, and a new
shape changes only the parts that have it. What is not among the best of a part is not among the best of all, so that
the selection does not depend on the tree.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Any

import numpy as np

from pipeline.config.schema import Config
from pipeline.plan.progress import Progress
from pipeline.plan.work_item import WorkItem
from pipeline.stages.candidates import Shapes, Starts, Surprise, candidates, qcrs_of, read_rows
from pipeline.stages.collected import Collected
from pipeline.stages.policies import best_pairs, first_pool
from pipeline.stages.pool import Rows, best_rows
from pipeline.stages.qualities import doubtful
from pipeline.stages.stage import Stage
from pipeline.stages.wishes import wished_shapes
from pipeline.store.artifact import Artifact
from pipeline.store.keys import digest_text


@dataclass(frozen=True)
class Between:
    """The shapes of a part of the first level.

    The inputs after the blocks are the batches ``read``, by the number of their first shape, if doubtful shapes are
    left out, and, if the pairs are to be surprising, the collection, in which the shapes are at ``positions``.
    """

    shapes: Shapes
    read: tuple[int, ...]
    positions: tuple[range, ...]


@dataclass(frozen=True)
class Part:
    """A part of the pairs: its inputs are ``blocks`` with the QCRS of each pair, or smaller parts, and ``rare`` ones.

    Shapes are numbered within the part, which has ``count``: those of its rows, then those of its columns, unless these
    are the same. Only a part of the first level has shapes ``between`` which it lies.
    """

    blocks: tuple[tuple[int, int], ...]
    rare: tuple[tuple[int, int], ...]
    count: int
    between: Between | None


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: Part) -> Artifact:
    """Blocks of pairs, or smaller parts → rows i, j, score, n, and ``qcrs``, the score over every n.

    i and j number the shapes of the part; ``cut`` in the document says whether a larger pool would have more.
    """
    policy, size, pieces, least_surprise, mirrored = parameters
    end = len(spec.blocks) + len(spec.rare)
    blocks, rows = inputs[: len(spec.blocks)], _rows(inputs, spec, pieces, least_surprise, mirrored)
    cut = False
    if policy == "varied":
        best = best_rows(rows, spec.count, size)
    else:
        (first, second, score), cut = best_pairs((block[:3] for block in rows), first_pool(size))
        best = Rows(first, second, score, np.zeros(len(score), np.int64))
        if spec.between is None:
            cut = cut or any(part.document["cut"] for part in inputs[:end])
    i, j, n = best.i.astype(np.int32), best.j.astype(np.int32), best.n.astype(np.int16)
    qcrs = qcrs_of(best.i, best.j, spec.blocks, blocks)
    return Artifact({"i": i, "j": j, "n": n, "score": best.score, "qcrs": qcrs}, {"cut": bool(cut)})


def _rows(
    inputs: Sequence[Artifact], spec: Part, pieces: Sequence[int], least_surprise: float, mirrored: bool
) -> Iterable[Rows]:
    if spec.between is None:
        return read_rows(spec.blocks, inputs)
    starts = (*spec.blocks, *spec.rare)
    between, others = spec.between, inputs[len(starts) :]
    batches = dict(zip(between.read, others, strict=False))
    shapes = between.shapes.only(~doubtful(batches, spec.count))
    surprise = None
    if between.positions:
        positions = np.array(list(chain(*between.positions)))
        collection = others[len(between.read)].arrays
        surprise = Surprise(Collected.of(collection, int(positions.max()) + 1), positions, least_surprise, mirrored)
    return candidates(starts, inputs[: len(starts)], shapes, pieces, surprise)


def items(progress: Progress) -> list[WorkItem]:
    """The parts of every level, a level after the other; none of a collection whose blocks the selection reads itself.

    Each level has a part for every two of its spans of groups, and for each with itself.
    """
    if len(progress.spans) == 1:
        return []
    level = _first_level(progress)
    work = [*level.values()]
    for spans in progress.spans[2:]:
        smaller = _grouped(level, spans)
        level = {sides: _joined(progress, sides, smaller[sides]) for sides in _sides(spans)}
        work += level.values()
    return work


def last_level(progress: Progress) -> list[tuple[WorkItem, tuple[int, int]]]:
    """The parts that the selection reads, done or not, each with the positions of the shapes that its rows and its
    columns would number 0."""
    parts, sides = progress.work.get("preselect", ()), _sides(progress.spans[-1])
    every = range(len(progress.items)), range(len(progress.items))
    starts = [_start(every, _positions(progress, inner), of_part=True) for inner in sides]
    return list(zip(parts[-len(sides) :], starts, strict=True)) if parts else []


Sides = tuple[range, range]
"""Spans of groups on both sides of a block or part, or the positions of their shapes."""


def _sides(spans: Sequence[range]) -> list[Sides]:
    return [(first, second) for k, first in enumerate(spans) for second in spans[k:]]


def _first_level(progress: Progress) -> dict[Sides, WorkItem]:
    select = progress.config.select
    shapes = Shapes.of(progress.classes, wished_shapes(select, progress.items))
    groups = [range(number, number + 1) for number in range(len(progress.groups))]
    spans = progress.spans[1]
    scored = _grouped(_blocks(progress, "qcrs", groups), spans)
    rare = _grouped(_blocks(progress, "qcrs_rare", progress.spans[0]), spans)
    ingest = progress.finished("ingest") if progress.config.shape.doubtful == "drop" else []
    things = progress.finished("near_duplicates") if select.min_surprise > 0 else []
    return {
        sides: _between(progress, sides, (scored[sides], rare[sides]), shapes, ingest, things)
        for sides in _sides(spans)
    }


def _between(
    progress: Progress,
    sides: Sides,
    blocks: tuple[Mapping[Sides, WorkItem], Mapping[Sides, WorkItem]],
    shapes: Shapes,
    ingest: Sequence[WorkItem],
    things: Sequence[WorkItem],
) -> WorkItem:
    """A part of the first level."""
    here = _positions(progress, sides)
    starts, of_rare = (_starts(progress, here, inside, of_part=False) for inside in blocks)
    batches: dict[int, WorkItem] = {}
    for number, side in ((0, here[0]), (len(here[0]), here[1]))[: len({*here})]:
        low, high = (bisect_left(ingest, end, key=lambda item: item.members[0]) for end in (side.start, side.stop))
        batches |= {item.members[0] - side.start + number: item for item in ingest[low:high]}
    positions = tuple(dict.fromkeys(here)) if things else ()
    between = Between(shapes.at(*here), tuple(batches), positions)
    what = between.shapes.digest(), between.read, positions
    sources = [*chain(*(inside.values() for inside in blocks)), *batches.values(), *things]
    return _part(progress, here, (starts, of_rare), sources, between, what)


def _joined(progress: Progress, sides: Sides, parts: Mapping[Sides, WorkItem]) -> WorkItem:
    """A part of a higher level."""
    here = _positions(progress, sides)
    starts = _starts(progress, here, parts, of_part=True)
    return _part(progress, here, (starts, ()), [*parts.values()], None, ())


def _part(
    progress: Progress,
    here: Sides,
    starts: tuple[Starts, Starts],
    sources: Sequence[WorkItem],
    between: Between | None,
    what: tuple[Any, ...],
) -> WorkItem:
    recipe, count = progress.recipes["preselect"], sum(map(len, dict.fromkeys(here)))
    parts = recipe.parts([item.key for item in sources], digest_text(repr((starts, count, what))))
    spec = Part(tuple(starts[0]), tuple(starts[1]), count, between)
    return recipe.item(parts, [item.reference for item in sources], spec=spec)


def _blocks(progress: Progress, stage: str, spans: Sequence[range]) -> dict[Sides, WorkItem]:
    """Finished blocks by their spans of groups."""
    done = [(item, item.block) for item in progress.finished(stage) if item.block is not None]
    return {(spans[a], spans[b]): item for item, (a, b) in done}


def _positions(progress: Progress, sides: Sides) -> Sides:
    return progress.of_span(sides[0]), progress.of_span(sides[1])


def _grouped(level: Mapping[Sides, WorkItem], spans: Sequence[range]) -> dict[Sides, dict[Sides, WorkItem]]:
    """The blocks, or parts, of which both spans are in those of a larger part, by the larger part's."""
    around = {group: span for span in spans for group in span}
    grouped: dict[Sides, dict[Sides, WorkItem]] = {sides: {} for sides in _sides(spans)}
    for (first, second), item in level.items():
        grouped[around[first.start], around[second.start]][first, second] = item
    return grouped


def _starts(progress: Progress, here: Sides, inside: Iterable[Sides], *, of_part: bool) -> Starts:
    return [_start(here, _positions(progress, inner), of_part=of_part) for inner in inside]


def _start(here: Sides, inner: Sides, *, of_part: bool) -> tuple[int, int]:
    """The number in a part of the shapes that a block of it, or a smaller part, numbers 0 as row and as column."""
    (first, second), (rows, columns) = here, inner
    row, column = rows.start - first.start, columns.start - second.start
    if first != second:
        column += len(first)
    return row, column - len(rows) if of_part and rows != columns else column


def has_parts(config: Config) -> bool:
    """Whether a run selects from all pairs; by policy ``paper`` few of them may be selected, and are read at once."""
    return config.qcrs.mode == "all" and config.select.policy != "paper"


STAGE = Stage(
    name="preselect",
    unit="parts of the pairs",
    after=("ingest", "qcrs", "qcrs_rare", "near_duplicates"),
    parameters=(
        "select.policy",
        "select.selected",
        "select.pieces",
        "select.min_surprise",
        "likeness.mirrored",
    ),
    items=items,
    run=run,
    scope="part",
    wanted=has_parts,
)

"""Selection: which pairs go on to CRS, by policy, block by block (paper §5.3; other policies and breadth are ours)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pipeline.plan.progress import Progress
from pipeline.plan.work_item import WorkItem
from pipeline.stages.collected import Collected
from pipeline.stages.pool import Rows, fill_pool
from pipeline.stages.qualities import doubtful
from pipeline.stages.stage import Stage
from pipeline.stages.wishes import WishedShapes, wished_shapes
from pipeline.store.artifact import AnyArray, Artifact
from pipeline.store.keys import digest_text
from riot.types import FloatArray, IntArray

if TYPE_CHECKING:
    from pipeline.config.schema import SelectConfig

Block = tuple[IntArray, IntArray, FloatArray]
"""Pairs of one block: i, j (positions in the collection, i < j) and score."""


class Chosen(NamedTuple):
    """Selected pairs, best first: ``pairs`` (p, 2) int64, positions i < j in the collection, ``score`` (p,) float64."""

    pairs: IntArray
    score: FloatArray


FIRST_POOL = 50_000
"""Best pairs in the first pool, of 24 bytes each; the limits seldom need more (measured on MPEG-7)."""

GROWTH = 8
"""Factor by which the pool grows if they do: a few readings, and a pool not much larger than needed (ours)."""


@dataclass(frozen=True)
class Selecting:
    """What selection reads of the collection.

    ``classes`` are by position, ``starts`` the positions of the batches' first shapes. The inputs are, in this order,
    scores of ``blocks`` and of the blocks ``rare``, by the positions of their first shapes on both sides, reversibility
    of ``rated`` and the shapes ``read``, if those in doubt are left out, by numbers of batches, and, if it is
    ``described``, the collection. ``wishes`` are the pairs that the user wants.
    """

    classes: tuple[str, ...]
    starts: tuple[int, ...]
    blocks: tuple[tuple[int, int], ...]
    rare: tuple[tuple[int, int], ...]
    rated: tuple[int, ...]
    described: bool
    wishes: WishedShapes
    read: tuple[int, ...] = ()


@dataclass(frozen=True)
class SelectionLimits:
    """The greatest numbers of pairs: in all, of the same two classes, and with the same shape."""

    top: int
    per_class_pair: int
    per_shape: int


def select_paper(blocks: Iterator[Block], classes: Sequence[str], scores: FloatArray, top: int) -> Chosen:
    """The best pairs among the shapes of best reversibility ``scores`` (nan = none) of each class.

    A shape of class "" is a class of its own. Ties go to the earlier shape.
    """
    best: dict[str, int] = {}
    for position, name in enumerate(classes):
        if np.isnan(scores[position]):
            continue
        group = name or f"\0{position}"
        if group not in best or scores[position] > scores[best[group]]:
            best[group] = position
    chosen = np.zeros(len(classes), dtype=bool)
    chosen[list(best.values())] = True
    pool, _ = _pool(blocks, lambda i, j: chosen[i] & chosen[j], limit=max(FIRST_POOL, top))
    return _rows(pool, slice(top))


def select_global(blocks: Callable[[], Iterator[Block]], classes: Sequence[str], limits: SelectionLimits) -> Chosen:
    """The best pairs of different classes within the limits, greedily by falling score.

    Class "" differs from every class, itself too. Ties go to the earlier pair. ``blocks`` starts the reading anew:
    only a pool of the best pairs is held, and a larger one is read when the limits use up the first.
    """
    label = labels(classes)
    size = max(FIRST_POOL, limits.top)
    while True:
        pool, cut = _pool(blocks(), lambda i, j: label[i] != label[j], size)
        rows = greedy(pool[0], pool[1], label, limits)
        if len(rows) == limits.top or not cut:
            return _rows(pool, rows)
        size *= GROWTH


def _rows(pool: Block, rows: slice | list[int]) -> Chosen:
    i, j, score = pool
    index = np.arange(len(score))[rows] if isinstance(rows, slice) else np.array(rows, dtype=np.int64)
    return Chosen(np.column_stack([i[index], j[index]]), score[index])


def labels(classes: Sequence[str]) -> IntArray:
    """A number for every class, by position; class "" differs from every class, itself too."""
    numbers: dict[str, int] = {}
    label = [numbers.setdefault(name or f"\0{position}", len(numbers)) for position, name in enumerate(classes)]
    return np.array(label, dtype=np.int64)


def greedy(i: IntArray, j: IntArray, label: IntArray, limits: SelectionLimits) -> list[int]:
    """Take pairs (p,), the best first, as long as the limits allow; returns the rows of those taken."""
    shapes: Counter[int] = Counter()
    class_pairs: Counter[tuple[int, int]] = Counter()
    chosen: list[int] = []
    for row, (first, second) in enumerate(zip(i.tolist(), j.tolist(), strict=True)):
        low, high = sorted((int(label[first]), int(label[second])))
        if class_pairs[low, high] >= limits.per_class_pair:
            continue
        if max(shapes[first], shapes[second]) >= limits.per_shape:
            continue
        class_pairs[low, high] += 1
        shapes[first] += 1
        shapes[second] += 1
        chosen.append(row)
        if len(chosen) == limits.top:
            break
    return chosen


def _pool(blocks: Iterator[Block], keep: Callable[[IntArray, IntArray], Any], limit: int) -> tuple[Block, bool]:
    """The ``limit`` best pairs with a score above 0 that ``keep`` admits, best first; and whether there are more."""
    none = np.empty(0, np.int64)
    held: list[Block] = [(none, none, np.empty(0))]
    count, least, cut = 0, 0.0, False
    for i, j, score in blocks:
        # A pair below the last of a full pool cannot enter it; at an equal score the order of pairs decides.
        mask = (score > 0) & (score >= least)
        mask[mask] = keep(i[mask], j[mask])
        held.append((i[mask], j[mask], score[mask]))
        count += len(held[-1][2])
        if count > 2 * limit:
            held, cut = [_best(held, limit)], True
            count, least = limit, float(held[0][2][-1])
    cut = cut or count > limit
    return _best(held, limit), cut


def _best(held: Sequence[Block], limit: int) -> Block:
    i, j = (np.concatenate([block[side] for block in held]) for side in (0, 1))
    score = np.concatenate([block[2] for block in held])
    order = np.lexsort((j, i, -score))[:limit]
    return i[order], j[order], score[order]


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: Selecting) -> Artifact:
    """The inputs that `Selecting` lists → ``pairs`` (p, 2) int64, best first, ``score`` (p,): QCRS.

    Only one input is in memory at a time: there are as many as blocks.
    """
    settings, mirrored, _ = parameters
    ends = np.cumsum([len(spec.blocks), len(spec.rare), len(spec.rated), len(spec.read)]).tolist()
    scored, rare, rated = inputs[: ends[0]], inputs[ends[0] : ends[1]], inputs[ends[1] : ends[2]]
    read = {spec.starts[number]: batch for number, batch in zip(spec.read, inputs[ends[2] : ends[3]], strict=True)}
    wished, clear = spec.wishes.of(len(spec.classes)), ~doubtful(read, len(spec.classes))

    def rows(starts: Sequence[tuple[int, int]], artifacts: Sequence[Artifact]) -> Iterator[Rows]:
        for (first, second), block in zip(starts, artifacts, strict=True):
            i = block.arrays["i"].astype(np.int64) + first
            j = block.arrays["j"].astype(np.int64) + second
            score, n = np.asarray(block.arrays["score"]), block.arrays["n"].astype(np.int64)
            yield Rows(i, j, score, n).at(wished(i, j) & clear[i] & clear[j])

    def blocks() -> Iterator[Block]:
        return (block[:3] for block in rows(spec.blocks, scored))

    if settings.policy == "varied":
        every = chain(rows(spec.blocks, scored), rows(spec.rare, rare))
        things = inputs[-1].arrays if spec.described else {}
        chosen = _scored(select_varied(every, spec.classes, things, settings, mirrored), blocks())
    elif settings.policy == "paper":
        ratings = np.full(len(spec.classes), np.nan)
        for number, batch in zip(spec.rated, rated, strict=True):
            start = spec.starts[number]
            ratings[start : start + len(batch.arrays["score"])] = batch.arrays["score"]
        ratings[~clear] = np.nan
        chosen = select_paper(blocks(), spec.classes, ratings, settings.breadth_of_policy * settings.top)
    else:
        widened = (settings.top, settings.per_class_pair, settings.per_shape)
        limits = SelectionLimits(*(settings.breadth_of_policy * most for most in widened))
        chosen = select_global(blocks, spec.classes, limits)
    return Artifact({"pairs": chosen.pairs, "score": chosen.score})


def select_varied(
    blocks: Iterator[Rows],
    classes: Sequence[str],
    things: Mapping[str, AnyArray],
    settings: SelectConfig,
    mirrored: bool,
) -> IntArray:
    """(k, 2) pairs of different classes for the pool (`fill_pool`), within the wishes for pieces and surprise.

    ``things`` are the arrays of the stage ``near_duplicates``, or none: then each shape is like no other.
    """
    collected, label = Collected.of(things, len(classes)), labels(classes)

    def wanted(block: Rows) -> Rows:
        keep = (block.score > 0) & (label[block.i] != label[block.j])
        if settings.pieces:
            keep &= np.isin(block.n, settings.pieces)
        block = block.at(keep)
        if settings.min_surprise > 0:
            surprise = collected.surprise(block.i, block.j, mirrored=mirrored)
            block = block.at(surprise >= settings.min_surprise)
        return block

    size = settings.breadth_of_policy * settings.top
    return fill_pool(map(wanted, blocks), collected.cluster, label, collected.perimeter, size)


def _scored(pairs: IntArray, blocks: Iterator[Block]) -> Chosen:
    """Pairs by falling QCRS, ties by pair; a pair enters the pool by its trunks of one n, which may score less."""
    order = np.lexsort((pairs[:, 1], pairs[:, 0]))
    pairs = pairs[order]
    count = int(pairs.max(initial=0)) + 1
    keys, score = pairs[:, 0] * count + pairs[:, 1], np.zeros(len(pairs))
    for i, j, block_score in blocks:
        within = np.flatnonzero((i < count) & (j < count))
        _, at, rows = np.intersect1d(keys, i[within] * count + j[within], assume_unique=True, return_indices=True)
        score[at] = block_score[within[rows]]
    order = np.argsort(-score, kind="stable")
    return Chosen(pairs[order], score[order])


def items(progress: Progress) -> list[WorkItem]:
    """One work item over the blocks that are done; unlike the other keys, its key holds the classes in order.

    With ``qcrs.mode=topk`` it is over the collected pairs, done or not, which number shapes by position, as the first
    batch does. The selection equals that from all pairs unless the limits and classes need a pair that is beyond
    the k best of both of its shapes.
    """
    if "pairs" in progress.work:
        blocks = dict.fromkeys([(0, 0)], progress.work["pairs"][0]) if progress.batches else {}
    else:
        blocks = {item.block: item for item in progress.finished("qcrs") if item.block is not None}
    varied = progress.config.select.policy == "varied"
    rare = {item.block: item for item in progress.finished("qcrs_rare") if item.block is not None}
    ratings = progress.work["reversibility"] if not varied else ()
    rated = [number for number, item in enumerate(ratings) if item.reference in progress.done]
    things = progress.finished("near_duplicates") if varied else []
    dropping = progress.config.shape.doubtful == "drop"
    ingest = progress.work["ingest"] if dropping else ()
    read = [number for number, item in enumerate(ingest) if item.reference in progress.done]
    per_batch = [*(ratings[number] for number in rated), *(ingest[number] for number in read)]
    sources = [*blocks.values(), *rare.values(), *per_batch, *things]
    starts = tuple(batch.start for batch in progress.batches)
    wishes = wished_shapes(progress.config.select, progress.items)
    first = [progress.of_group(number).start for number in range(len(progress.groups))]
    of_blocks, of_rare = (tuple((first[a], first[b]) for a, b in numbers) for numbers in (blocks, rare))
    spec = Selecting(progress.classes, starts, of_blocks, of_rare, tuple(rated), bool(things), wishes, tuple(read))
    recipe = progress.recipes["select"]
    # A digest instead of the spec keeps the classes out of the manifest.
    parts = recipe.parts([item.key for item in sources], digest_text(repr(spec)))
    return [recipe.item(parts, [item.reference for item in sources], spec=spec)]


def selected(progress: Progress) -> Chosen:
    """The pairs that a finished selection chose, best first, with their scores; none if it failed."""
    for item in progress.finished("select"):
        arrays = progress.read(item).arrays
        return Chosen(np.array(arrays["pairs"]), np.array(arrays["score"]))
    return Chosen(np.empty((0, 2), dtype=np.int64), np.empty(0))


STAGE = Stage(
    name="select",
    unit="selection",
    after=("ingest", "qcrs", "qcrs_rare", "pairs", "reversibility", "near_duplicates"),
    parameters=("select", "likeness.mirrored", "shape.doubtful"),
    items=items,
    run=run,
    scope="collection",
    here=True,
)

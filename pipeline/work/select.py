"""Selection: which pairs go on, by policy, reading the scores block by block (paper §5.3; ``global`` is ours)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pipeline.artifact import Artifact
from riot.shape import FloatArray, IntArray

Block = tuple[IntArray, IntArray, FloatArray]
"""Pairs of one block: i, j (positions in the collection, i < j) and score."""

FIRST_POOL = 50_000
GROWTH = 8


@dataclass(frozen=True)
class Limits:
    """How many pairs: in all, of the same two classes, with the same shape."""

    top: int
    per_class_pair: int
    per_shape: int


def select_paper(blocks: Iterator[Block], classes: Sequence[str], scores: FloatArray, top: int) -> list[int]:
    """The best pairs among the shapes of best reversibility ``scores`` (nan = none) of each class, flattened (i, j, …).

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
    i, j, _, _ = _pool(blocks, lambda i, j: chosen[i] & chosen[j], limit=max(FIRST_POOL, top))
    return np.column_stack([i, j])[:top].reshape(-1).tolist()


def select_global(blocks: Callable[[], Iterator[Block]], classes: Sequence[str], limits: Limits) -> list[int]:
    """The best pairs of different classes within the limits, greedily by falling score, flattened (i, j, …).

    Class "" differs from every class, itself too. Ties go to the earlier pair. ``blocks`` starts the reading anew:
    only a pool of the best pairs is held, and a larger one is read when the limits use up the first.
    """
    numbers: dict[str, int] = {}
    label = np.array(
        [numbers.setdefault(name or f"\0{position}", len(numbers)) for position, name in enumerate(classes)],
        dtype=np.int64,
    )
    size = max(FIRST_POOL, limits.top)
    while True:
        i, j, _, cut = _pool(blocks(), lambda i, j: label[i] != label[j], size)
        chosen = _greedy(i, j, label, limits)
        if len(chosen) == 2 * limits.top or not cut:
            return chosen
        size *= GROWTH


def _greedy(i: IntArray, j: IntArray, label: IntArray, limits: Limits) -> list[int]:
    shapes: Counter[int] = Counter()
    class_pairs: Counter[tuple[int, int]] = Counter()
    chosen: list[int] = []
    for one, other in zip(i.tolist(), j.tolist(), strict=True):
        low, high = sorted((int(label[one]), int(label[other])))
        if class_pairs[low, high] >= limits.per_class_pair:
            continue
        if max(shapes[one], shapes[other]) >= limits.per_shape:
            continue
        class_pairs[low, high] += 1
        shapes[one] += 1
        shapes[other] += 1
        chosen += [one, other]
        if len(chosen) == 2 * limits.top:
            break
    return chosen


def _pool(
    blocks: Iterator[Block], keep: Callable[[IntArray, IntArray], Any], limit: int
) -> tuple[IntArray, IntArray, FloatArray, bool]:
    """The best ``limit`` pairs with a score above 0 that ``keep`` admits, best first; and whether any was cut off."""
    i, j, score = np.empty(0, np.int64), np.empty(0, np.int64), np.empty(0)
    cut = False
    for block_i, block_j, block_score in blocks:
        mask = (block_score > 0) & keep(block_i, block_j)
        i, j = np.concatenate([i, block_i[mask]]), np.concatenate([j, block_j[mask]])
        score = np.concatenate([score, block_score[mask]])
        if len(score) > 2 * limit:
            cut = True
            order = np.lexsort((j, i, -score))[:limit]
            i, j, score = i[order], j[order], score[order]
    order = np.lexsort((j, i, -score))
    cut = cut or len(order) > limit
    order = order[:limit]
    return i[order], j[order], score[order], cut


@dataclass(frozen=True)
class Spec:
    """What selection knows of the collection: classes by position; where each batch starts; the inputs' batches."""

    classes: tuple[str, ...]
    starts: tuple[int, ...]
    blocks: tuple[tuple[int, int], ...]
    rated: tuple[int, ...]


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: Spec) -> Artifact:
    """Blocks of scores, then the batches' reversibility → ``pairs`` (p, 2) int64, best first, ``score`` (p,)."""
    (settings,) = parameters
    scored, rated = inputs[: len(spec.blocks)], inputs[len(spec.blocks) :]

    def blocks() -> Iterator[Block]:
        for (a, b), block in zip(spec.blocks, scored, strict=True):
            i = block.arrays["i"].astype(np.int64) + spec.starts[a]
            j = block.arrays["j"].astype(np.int64) + spec.starts[b]
            yield i, j, np.asarray(block.arrays["score"])

    if settings.policy == "paper":
        ratings = np.full(len(spec.classes), np.nan)
        for number, batch in zip(spec.rated, rated, strict=True):
            start = spec.starts[number]
            ratings[start : start + len(batch.arrays["score"])] = batch.arrays["score"]
        chosen = select_paper(blocks(), spec.classes, ratings, settings.top)
    else:
        limits = Limits(settings.top, settings.per_class_pair, settings.per_shape)
        chosen = select_global(blocks, spec.classes, limits)
    pairs = np.array(chosen, dtype=np.int64).reshape(-1, 2)
    return Artifact({"pairs": pairs, "score": _scores(blocks(), pairs, len(spec.classes))})


def _scores(blocks: Iterator[Block], pairs: IntArray, count: int) -> FloatArray:
    wanted = pairs[:, 0] * count + pairs[:, 1]
    order = np.argsort(wanted)
    found = np.zeros(len(pairs))
    for i, j, score in blocks:
        codes = i * count + j
        at = np.searchsorted(wanted[order], codes)
        hit = at < len(wanted)
        hit[hit] = wanted[order][at[hit]] == codes[hit]
        found[order[at[hit]]] = score[hit]
    return found

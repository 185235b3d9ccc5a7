"""The pairs of the quiz: half of them reversible with little deformation, half of them not, and else alike. Ours."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeline.errors import StartError
from pipeline.study.finished import StudiedRun
from pipeline.study.partners import StudiedPartners
from riot.types import BoolArray, FloatArray, IntArray

NEAREST = 40
"""A pair's counterparts are sought among so many shapes whose reversibility is nearest to that of its first shape, and
as many nearest to that of its second."""

LOW = 0.1
"""Of these, the pairs in the lowest share of QCRS."""

TRIED = 100
"""Of these, so many whose reversibility is nearest."""


@dataclass(frozen=True)
class QuizPair:
    """Two shapes, by number, as the quiz shows them, and what is known of them.

    ``worth`` is the IoU of the worse shape with its input: of the certified transform if the pair is reversible, else
    the greatest that refined trunks allow. ``file`` is the transform's, relative to the run's folder; "" without one.
    """

    left: int
    right: int
    reversible: bool
    worth: float
    quick: float
    cross: float
    file: str = ""


def choose(
    finished: StudiedRun, partners: StudiedPartners, count: int, margin: float, rng: np.random.Generator
) -> list[QuizPair]:
    """``count`` pairs, an even number, in an order drawn by lot; no shape is in two of them.

    One half are certified transforms of the run. Each has a counterpart among the other half: two other shapes, about
    equally reversible on their own, with low QCRS, whose refined trunks allow an IoU that is ``margin`` below the
    least of the first half. Raises `StartError` if the run has too few of either.
    """
    yes = reversible_pairs(finished, count // 2, rng)
    limit = min(pair.worth for pair in yes) - margin
    pairs = yes + _counterparts(finished, partners, yes, limit, rng)
    turned = rng.random(len(pairs)) < 0.5
    shown = [
        replace(pair, left=pair.right, right=pair.left) if turn else pair
        for pair, turn in zip(pairs, turned, strict=True)
    ]
    return [shown[k] for k in rng.permutation(len(shown)).tolist()]


def reversible_pairs(finished: StudiedRun, count: int, rng: np.random.Generator) -> list[QuizPair]:
    """Chosen certified transforms by lot from the half of highest rank, and from the others if these are too few.

    No shape is in two of them, nor, as long as there are others, is a pair of classes. Raises `StartError`.
    """
    certified = [
        row for row in finished.table("transforms").to_pylist() if row["chosen"] and row["status"] == "certified"
    ]
    best = (len(certified) + 1) // 2
    lots = [certified[k] for k in rng.permutation(best).tolist()] + certified[best:]
    chosen: list[QuizPair] = []
    used: set[int] = set()
    kinds: set[frozenset[str]] = set()
    for again in (False, True):
        for row in lots:
            kind = frozenset((row["class_i"], row["class_j"]))
            if len(chosen) == count or used & {row["i"], row["j"]} or (not again and kind in kinds):
                continue
            used |= {row["i"], row["j"]}
            kinds.add(kind)
            chosen.append(QuizPair(row["i"], row["j"], True, row["iou"], row["qcrs"], row["crs"], row["file"]))
    if not chosen:
        raise StartError(f"{finished.mined.folder}: no certified transform; the quiz needs a run that made some")
    if len(chosen) < count:
        raise StartError(
            f"{finished.mined.folder}: {count} certified transforms without a shape in common are needed, and "
            f"{len(chosen)} were found; give pairs={2 * len(chosen)}, or run with a greater select.top"
        )
    return chosen


def _counterparts(
    finished: StudiedRun, partners: StudiedPartners, pairs: Sequence[QuizPair], limit: float, rng: np.random.Generator
) -> list[QuizPair]:
    """One pair for each of ``pairs`` that is not reversible with an IoU above ``limit``; raises `StartError`."""
    score = finished.values("reversibility", "score")
    # Without trunks QCRS and CRS are 0 for want of anything to compare, which shows no pair to be irreversible.
    free = np.isfinite(score) & (finished.values("shapes", "trunks") > 0)
    free[[number for pair in pairs for number in (pair.left, pair.right)]] = False
    counterparts: list[QuizPair] = []
    for pair in pairs:
        for (left, right), quick in _alike(finished, pair, score, free, rng):
            bound = partners.bound(left, right)
            if bound <= limit:
                counterparts.append(QuizPair(left, right, False, max(bound, 0.0), quick, partners.cross(left, right)))
                free[[left, right]] = False
                break
        else:
            names = " and ".join(finished.mined.names[number] for number in (pair.left, pair.right))
            raise StartError(
                f"{finished.mined.folder}: no pair as reversible by its shapes as {names} has an IoU of {limit:.3f} or "
                "less; give fewer pairs, a smaller margin, or a greater collection"
            )
    return counterparts


def _alike(
    finished: StudiedRun, pair: QuizPair, score: FloatArray, free: BoolArray, rng: np.random.Generator
) -> Iterator[tuple[tuple[int, int], float]]:
    """Pairs (left, right) of ``free`` shapes as reversible as those of ``pair``, of low QCRS, in an order by lot."""
    sides = [_nearest(score, free, score[number]) for number in (pair.left, pair.right)]
    grid: IntArray = np.stack(np.meshgrid(*sides, indexing="ij"), axis=2).reshape(-1, 2)
    classes = np.array(finished.classes)
    between = classes[pair.left] != classes[pair.right]
    grid = grid[grid[:, 0] != grid[:, 1]]
    # A pair within a class would stand out among pairs of different classes.
    grid = grid[(classes[grid[:, 0]] != classes[grid[:, 1]]) == between]
    if not len(grid):
        return
    quick = finished.quick_scores(np.sort(grid, axis=1))
    low = quick <= np.nanquantile(quick, LOW)
    grid, quick = grid[low], quick[low]
    apart = np.abs(score[grid] - score[[pair.left, pair.right]]).sum(axis=1)
    for k in rng.permutation(np.argsort(apart, kind="stable")[:TRIED]).tolist():
        left, right = grid[k].tolist()
        yield (left, right), float(quick[k])


def _nearest(score: FloatArray, free: BoolArray, to: float) -> IntArray:
    """Numbers of the free shapes whose score is nearest to one."""
    apart = np.where(free, np.abs(score - to), math.inf)
    order = np.argsort(apart, kind="stable")[:NEAREST]
    nearest: IntArray = order[np.isfinite(apart[order])]
    return nearest

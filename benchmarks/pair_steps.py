"""Steps on pairs: QCRS, CRS, and construction with its certificate."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
import shapely
from floors import Floor, Rates, brute_floor, quick_floor, stack_floor
from inputs import Size
from measure import least_seconds, time_items, time_shares
from overlay import overlay_best_trunk_pairs
from shape_steps import Shapes
from table import Row, row

from riot.construction.plan_search import refine_scored
from riot.construction.plan_transform import construct_plans
from riot.geometry.shape import Shape
from riot.kernels.coverage import area_terms
from riot.parameters import ConstructParameters, CrsParameters, RefineParameters
from riot.scores.crs import AREA_SLACK, CrossScore, best_trunk_pairs
from riot.scores.qcrs import BlockScores, brute_force, score_block
from riot.scores.trunk_stack import TrunkStack, stack
from riot.scores.trunks import Trunks
from riot.transform.certificate import certify
from riot.transform.deformation import measure_deformation
from riot.transform.transform import Transform

AGREE = 1e-12
"""Greatest difference between a pruned and a brute-force QCRS."""

WANTED = RefineParameters().candidates
"""Trunk pairs that CRS is asked for, as in the pipeline."""


NO_TRUNKS = Trunks(np.zeros(1, np.int64), np.empty(0, np.int32), *(np.empty(0) for _ in range(4)))


@dataclass(frozen=True)
class Block:
    """Two batches of shapes, by the numbers of their first, and whether they are the same one."""

    a: TrunkStack
    b: TrunkStack
    start_a: int
    start_b: int

    @property
    def same(self) -> bool:
        """Whether only i < j are pairs."""
        return self.start_a == self.start_b

    def score(self) -> BlockScores:
        """QCRS of all pairs."""
        return score_block(self.a, self.b, None, self.same)


def quick_steps(quick: Sequence[Trunks], size: Size, rates: Rates) -> tuple[list[Row], list[tuple[int, int]]]:
    """QCRS of all pairs and by brute force of some; the pairs with a score, in its order."""
    starts = range(0, len(quick), size.batch)
    prepared = time_items(_prepare, [quick[start : start + size.batch] for start in starts], size.repeats)
    per_shape = [ms / len(batch) for ms, batch in zip(prepared.ms, prepared.good, strict=True)]
    stacks = dict(zip(starts, prepared.good, strict=True))
    blocks = [Block(stacks[a], stacks[b], a, b) for a in starts for b in starts if a <= b]
    timed = time_items(Block.score, blocks, size.repeats)
    scored = timed.good
    pairs = sum(len(scores.score) for scores in scored)
    ms = [ms / len(scores.score) for ms, scores in zip(timed.ms, scored, strict=True) if len(scores.score)]

    chosen = np.unique(np.linspace(0, len(quick) - 1, min(size.brute_shapes, len(quick))).astype(np.int64))
    some = stack([quick[k] for k in chosen])
    fast = time_items(lambda _: score_block(some, some, None, True), [0], max(3, size.repeats))
    slow = time_items(lambda _: brute_force(some, some, None, True), [0])
    pruned, brute = fast.good[0], slow.good[0]
    compared = len(brute.score)
    agree = same_winners(pruned, brute)
    brute_ms = slow.ms[0] / compared
    rows = [
        row(
            *("stacks for QCRS", "shape", per_shape),
            mean=sum(prepared.ms) / len(quick),
            items=len(quick),
            floor=stack_floor(prepared.good, rates),
            bounded_by=time_shares(_prepare, [quick[: size.batch]]),
            note=f"once for all pairs of a batch; quantiles over {len(per_shape)} batches",
        ),
        row(
            *("QCRS", "pair", ms),
            mean=sum(timed.ms) / pairs,
            items=pairs,
            paper_ms=1_990.0,
            target_ms=0.1,
            target_ratio=50.0,
            reference=f"brute force on {compared} pairs",
            reference_ms=brute_ms,
            ratio=slow.ms[0] / fast.ms[0],
            floor=quick_floor(some, pruned, rates),
            bounded_by=time_shares(Block.score, blocks[:3]),
            agree=agree,
            note=f"quantiles over {len(ms)} blocks",
        ),
        row(
            *("QCRS by brute force", "pair", [brute_ms]),
            items=compared,
            floor=brute_floor(some, compared, rates),
            bounded_by="sums of differences",
        ),
    ]
    return rows, _ranked(blocks, scored)


def _prepare(trunks: Sequence[Trunks]) -> TrunkStack:
    """Stack and lay out a batch; scored with a shape without trunks, which costs next to nothing."""
    prepared = stack(trunks)
    score_block(prepared, stack([NO_TRUNKS]))
    return prepared


def same_winners(scores: BlockScores, other: BlockScores) -> bool:
    """Whether scores are equal within `AGREE`, and the trunk pairs that give them are the same."""
    names = ("i", "j", "n", "trunk_i", "trunk_j", "shift")
    same = all(np.array_equal(getattr(scores, name), getattr(other, name)) for name in names)
    return same and bool(np.abs(scores.score - other.score).max(initial=0.0) <= AGREE)


def _ranked(blocks: Sequence[Block], scored: Sequence[BlockScores]) -> list[tuple[int, int]]:
    """Pairs with a score, the best first; among equals the first by (i, j)."""
    listed = [
        (-float(score), int(i) + block.start_a, int(j) + block.start_b)
        for block, scores in zip(blocks, scored, strict=True)
        for i, j, score in zip(scores.i, scores.j, scores.score, strict=True)
        if score > 0.0
    ]
    return [(i, j) for _, i, j in sorted(listed)]


@dataclass(frozen=True)
class Pair:
    """Two shapes with their full trunks."""

    p: Shape
    q: Shape
    trunks_p: Trunks
    trunks_q: Trunks

    def cross(self) -> list[CrossScore]:
        """The best trunk pairs by CRS."""
        return best_trunk_pairs(self.p, self.q, self.trunks_p, self.trunks_q, count=WANTED)

    def overlaid(self) -> list[float]:
        """Their scores by polygon overlay."""
        best = overlay_best_trunk_pairs(self.p, self.q, self.trunks_p, self.trunks_q, count=WANTED)
        return [math.exp(-0.5 * score.distance**2) for score in best]


def cross_steps(given: Shapes, ranked: Sequence[tuple[int, int]], size: Size, rates: Rates) -> list[Row]:
    """CRS with the trunk pairs that construction asks for, then construction on them."""
    chosen = ranked[: size.pairs]
    pairs = [Pair(given.shapes[i], given.shapes[j], given.full[i], given.full[j]) for i, j in chosen]
    if not pairs:
        return []
    crs = time_items(Pair.cross, pairs, size.repeats)
    few = pairs[: size.overlay_pairs]
    overlaid = time_items(Pair.overlaid, few)
    tolerance = AREA_SLACK / CrsParameters().sigma_area
    agree = all(
        len(exact) == len(scores)
        and bool(np.allclose([score.score for score in scores], exact, rtol=0.0, atol=tolerance))
        for exact, scores in zip(overlaid.good, crs.good, strict=False)
    )
    evaluations = float(np.mean([scores[0].evaluations for scores in crs.good if scores] or [0]))
    rows = [
        row(
            *("CRS", "pair", crs.ms),
            paper_ms=11_900.0,
            target_ms=10.0,
            reference=f"best-first by polygon overlay on {len(few)} pairs",
            reference_ms=overlaid.mean,
            ratio=sum(overlaid.ms) / sum(crs.ms[: len(few)]),
            floor=_cross_floor(pairs, crs.good),
            bounded_by=time_shares(Pair.cross, pairs[:12]),
            agree=agree,
            note=f"{evaluations:.0f} area terms begun",
        )
    ]
    ready = [(pair, scores) for pair, scores in zip(pairs, crs.good, strict=True) if scores]
    return [*rows, _construct_row(ready, size, crs.mean)] if ready else rows


def _cross_floor(pairs: Sequence[Pair], scored: Sequence[list[CrossScore]]) -> Floor:
    """The area terms of those trunk pairs only that are given back, both ways."""
    terms, seconds, lines = 0, 0.0, CrsParameters().lines
    for pair, scores in zip(pairs, scored, strict=True):
        for n in sorted({score.n for score in scores}):
            rows_p = np.array([score.trunk_a for score in scores if score.n == n])
            rows_q = np.array([score.trunk_b for score in scores if score.n == n])
            evaluate = partial(area_terms, np.array(pair.p.points), np.array(pair.q.points), rows_p, rows_q, lines)
            seconds += least_seconds(evaluate, 3)
            terms += len(rows_p)
    counts = {"area_terms": terms / len(pairs)}
    return Floor(1e3 * seconds / len(pairs), counts, f"{counts['area_terms']:.0f} area terms that are given back")


def _construct_row(ready: Sequence[tuple[Pair, list[CrossScore]]], size: Size, crs_ms: float) -> Row:
    constructions = time_items(_construct, ready, min(size.repeats, 2))
    transforms = constructions.good
    seconds = sum(least_seconds(partial(_unions, transform), 3) for transform in transforms)
    floor = None
    if transforms:
        points = float(np.mean([sum(len(piece.polygon) for piece in transform.pieces) for transform in transforms]))
        counts = {"polygon_points": points}
        floor = Floor(1e3 * seconds / len(transforms), counts, f"the two unions of the pieces, {points:.0f} points")
    iou = [measure_deformation(transform).iou for transform in transforms]
    certified = all(certify(transform).passed for transform in transforms)
    return row(
        *("construction", "pair", constructions.ms),
        failed=len(ready) - len(transforms),
        paper_ms=131_000.0,
        target_ms=300.0,
        reference="CRS of the same pairs",
        reference_ms=crs_ms,
        floor=floor,
        bounded_by=time_shares(_construct, ready[:12]),
        note=f"{'all' if certified else 'NOT all'} certified, median IoU {np.median(iou):.3f}" if iou else "",
    )


def _construct(item: tuple[Pair, list[CrossScore]]) -> Transform:
    pair, scores = item
    transform = construct_plans(*refine_scored(pair.p, pair.q, scores, RefineParameters()), ConstructParameters())
    certify(transform)
    measure_deformation(transform)
    return transform


def _unions(transform: Transform) -> None:
    for t in (0.0, 1.0):
        shapely.union_all([shapely.Polygon(piece) for piece in transform.parts(transform.pose(t))])

"""The bound of an exact construction, its gradient, and the refinement that raises it."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from blobs import blob, pair_shapes

from riot import Shape
from riot.construction.given_trunks import given_pair
from riot.construction.plan import ConstructionPlan, TrunkPair, plan_pair
from riot.construction.plan_search import drop_without_contact, refine_best
from riot.construction.plan_transform import construct_plan
from riot.construction.refine import refine
from riot.errors import ConstructionError
from riot.geometry.polyline import edge_lengths
from riot.groundtruth.pairs import exact_pair
from riot.kernels.change import least_changes
from riot.kernels.conjugate import conjugated, edge_differences, tangential
from riot.parameters import ConstructParameters, RefineParameters
from riot.scores.crs import best_trunk_pairs
from riot.transform.pose import rotate
from riot.units import D_C

PARAMETERS = RefineParameters()


@cache
def plans(seed_p: int, seed_q: int) -> list[ConstructionPlan]:
    a, b = blob(seed_p), blob(seed_q)
    candidates = []
    for score in best_trunk_pairs(a, b, count=6):
        try:
            candidates.append(plan_pair(TrunkPair(a, b, a.points, b.points, score.trunk_a, score.trunk_b)))
        except ConstructionError:
            continue
    return candidates


@pytest.mark.parametrize(("seed_p", "seed_q"), [(1, 2), (4, 9)])
def test_arcs_are_carried_rigidly_and_end_on_the_corners(seed_p: int, seed_q: int) -> None:
    plan = plans(seed_p, seed_q)[0]
    outline, n = plan.pair.p.points, len(plan.trunk_p)
    on_shape = edge_lengths(outline)
    matched = 0
    for i in range(n):
        arc = plan.arcs_p[plan.offsets_p[i] : plan.offsets_p[i + 1]]
        assert np.array_equal(arc[[0, -1]], plan.trunk_q[[i, (i + 1) % n]])
        lengths = np.hypot(*np.diff(arc, axis=0).T)
        matched += sum(np.abs(on_shape - length).min() < 1e-12 for length in lengths)
    # All edges of the outline but those that the feet divide.
    assert matched >= len(outline) - n
    assert np.abs(edge_lengths(plan.trunk_p) - edge_lengths(plan.trunk_q)).max() < 1e-12


@pytest.mark.parametrize(("seed_p", "seed_q"), [(1, 2), (4, 9)])
def test_gradient_is_that_of_the_bounds(seed_p: int, seed_q: int) -> None:
    plan = plans(seed_p, seed_q)[0]
    _, gradient = least_changes(*plan.pair.windowed_outlines, plan.trunks, 4096)
    step = 1e-4
    for corner in np.ndindex(plan.trunks.shape):
        change = np.zeros_like(plan.trunks)
        change[corner] = step
        above, _ = least_changes(*plan.pair.windowed_outlines, plan.trunks + change, 20000)
        below, _ = least_changes(*plan.pair.windowed_outlines, plan.trunks - change, 20000)
        # What moves besides the arcs are the connectors, short where the corners are near the boundary.
        assert gradient[(slice(None), *corner)] == pytest.approx((above - below) / (2.0 * step), abs=0.06)


def test_tangential_gradient_keeps_corresponding_edges_equal() -> None:
    trunks = plans(1, 2)[0].trunks
    rng = np.random.default_rng(0)
    along = tangential(trunks, rng.normal(size=trunks.shape))
    _, jacobian = edge_differences(trunks)
    assert np.abs(jacobian @ along.ravel()).max() < 1e-12
    moved, worst = conjugated(trunks + 1e-3 * along, 1e-14, 50)
    assert worst < 1e-12
    assert np.abs(moved - trunks - 1e-3 * along).max() < 1e-4


@pytest.mark.parametrize(("seed_p", "seed_q"), [(1, 2), (4, 9), (7, 3)])
def test_refinement_raises_the_bound_and_stays_conjugate(seed_p: int, seed_q: int) -> None:
    before = plans(seed_p, seed_q)
    after = [refine(plan, 24, PARAMETERS) for plan in before]
    assert all(new.bound >= old.bound for old, new in zip(before, after, strict=True))
    assert max(new.bound - old.bound for old, new in zip(before, after, strict=True)) > 0.01
    for plan in after:
        assert np.abs(edge_lengths(plan.trunk_p) - edge_lengths(plan.trunk_q)).max() < 1e-12
    for old, new in zip(before, after, strict=True):
        assert np.abs(new.trunks - old.trunks).max() <= PARAMETERS.slide * D_C
    best = refine_best(before, PARAMETERS)
    assert [plan.bound for plan in best] == sorted((plan.bound for plan in best), reverse=True)
    assert best[0].bound >= max(plan.bound for plan in after) - 0.01


def test_refinement_leaves_an_exact_pair_where_it_is() -> None:
    pair = exact_pair(4, 3)
    p, q = pair_shapes(pair)
    trunks = p.from_source(pair.trunk_p), q.from_source(pair.trunk_q)
    plan = plan_pair(given_pair(p, q, *trunks, 0.1, PARAMETERS.reach))
    assert plan.bound > 0.9999
    assert refine(plan, 24, PARAMETERS).bound >= plan.bound


def test_refinement_does_not_depend_on_where_the_shapes_lie() -> None:
    plan = plans(1, 2)[0]
    pair = plan.pair
    turned = Shape(rotate(pair.p.points, 0.5 * np.pi), pair.p.feature, pair.p.name)
    again = plan_pair(TrunkPair(turned, pair.q, turned.points, pair.outline_q, pair.trunk_p, pair.trunk_q))
    assert again.bound == pytest.approx(plan.bound, abs=1e-3)
    assert refine(again, 24, PARAMETERS).bound == pytest.approx(refine(plan, 24, PARAMETERS).bound, abs=5e-3)


def test_plans_that_lose_contact_are_dropped_before_one_that_does_not() -> None:
    candidates = plans(1, 2)
    usual = ConstructParameters()
    kept, errors = drop_without_contact(candidates, usual.spacing, usual.max_lost_contact)
    assert len(kept) + len(errors) == len(candidates)
    assert all(error.reason == "lost-contact" for error in errors)
    transform = construct_plan(kept[0], usual)
    assert min(transform.overlap_ratios) > kept[0].bound - 0.01
    # With no loss allowed at all nothing passes, and each says why.
    none, errors = drop_without_contact(candidates, usual.spacing, -1.0)
    assert none == [] and len(errors) == len(candidates)

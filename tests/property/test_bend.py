"""Bending: the gradient of what is maximised, the limits of strain, contact, and what must not change."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from blobs import blob, pair_shapes

from riot import Shape
from riot.construction import bend_objective
from riot.construction.bend import BentPlan, bend_plan, bend_plans
from riot.construction.bend_arcs import SwungArcs
from riot.construction.bend_contact import contact_cost
from riot.construction.bend_objective import BendObjective
from riot.construction.bent_side import BentSide
from riot.construction.given_trunks import given_pair
from riot.construction.plan import ConstructionPlan, plan_pair
from riot.construction.plan_search import plan_pairs, refine_best, trunk_pairs
from riot.construction.plan_transform import construct_plan
from riot.construction.trunk_choice import construct
from riot.geometry.bend import bend_shape
from riot.geometry.modes import Modes, modes
from riot.geometry.polyline import edge_lengths, is_simple
from riot.groundtruth.pairs import exact_pair
from riot.kernels.change import least_changes
from riot.kernels.pulls import nearest_arcs, pulls
from riot.parameters import BendParameters, ConstructParameters, RefineParameters
from riot.scores.crs import best_trunk_pairs
from riot.transform.deformation import overlap_ratio
from riot.types import FloatArray

PARAMETERS, REFINEMENT = BendParameters(), RefineParameters()
LINES = 2000


@cache
def plans(seed_p: int, seed_q: int) -> list[ConstructionPlan]:
    a, b = blob(seed_p), blob(seed_q)
    candidates, _ = plan_pairs(trunk_pairs(a, b, best_trunk_pairs(a, b, count=4), REFINEMENT.reach), REFINEMENT)
    return refine_best(candidates, REFINEMENT)


@cache
def elastic(seed: int) -> Modes:
    return modes(blob(seed), straight=PARAMETERS.straight)


@cache
def bent(seed_p: int, seed_q: int) -> BentPlan:
    return bend_plan(plans(seed_p, seed_q)[0], elastic(seed_p), elastic(seed_q), PARAMETERS)


def standing_lines(arcs: SwungArcs, lines: int) -> tuple[FloatArray, FloatArray]:
    """Areas by scanlines that do not move with the arcs."""
    return pulls(arcs.points, arcs.offsets, -2.0, 4.0 / lines, lines)


@pytest.mark.parametrize(("seed_p", "seed_q", "contact"), [(1, 2, 0.0), (4, 9, 0.0), (1, 2, 0.5)])
def test_gradient_is_that_of_the_objective(
    seed_p: int, seed_q: int, contact: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bend_objective, "areas_of", standing_lines)
    plan = plans(seed_p, seed_q)[0]
    p, windows_p, q, windows_q = plan.pair.windowed_outlines
    sides = BentSide.unbent(elastic(seed_p), p), BentSide.unbent(elastic(seed_q), q)
    objective = BendObjective(sides, (windows_p, windows_q), LINES, 60.0, 1.0, 0.5, contact, 0.3)
    rng = np.random.default_rng(0)
    trunks = plan.trunks + 0.01 * rng.normal(size=plan.trunks.shape)
    amplitudes = [0.03 * rng.normal(size=16) for _ in range(2)]
    _, by_trunks, by_amplitudes, _ = objective.rate(trunks, amplitudes)
    step = 1e-7
    for corner in np.ndindex(trunks.shape):
        change = np.zeros_like(trunks)
        change[corner] = step
        above, below = (objective.rate(trunks + sign * change, amplitudes)[0] for sign in (1, -1))
        assert by_trunks[corner] == pytest.approx((above - below) / (2.0 * step), abs=1e-6)
    for side, mode in np.ndindex(2, 16):
        change = np.zeros((2, 16))
        change[side, mode] = step
        above, below = (objective.rate(trunks, list(np.array(amplitudes) + s * change))[0] for s in (1, -1))
        assert by_amplitudes[side][mode] == pytest.approx((above - below) / (2.0 * step), abs=1e-6)


@pytest.mark.parametrize(("seed_p", "seed_q"), [(1, 2), (4, 9)])
def test_the_objective_of_unbent_shapes_is_the_bound(seed_p: int, seed_q: int) -> None:
    plan = plans(seed_p, seed_q)[0]
    p, windows_p, q, windows_q = plan.pair.windowed_outlines
    sides = BentSide.unbent(elastic(seed_p), p), BentSide.unbent(elastic(seed_q), q)
    objective = BendObjective(sides, (windows_p, windows_q), 512, 60.0, 0.0, 0.5, 0.0, 0.3)
    bounds, _ = least_changes(p, windows_p, q, windows_q, plan.trunks, 512)
    assert objective.rate(plan.trunks, [np.zeros(16)] * 2)[3] == pytest.approx(bounds.min(), abs=1e-4)


def test_gradient_of_energy_after_a_large_bend_and_modes_computed_anew() -> None:
    side = BentSide.unbent(elastic(1), blob(1).points)
    again = side.bent_again(np.random.default_rng(0).normal(size=16) * 0.03)
    assert again.energy(np.zeros(16), 1.0)[0] == pytest.approx(
        side.energy(a := np.random.default_rng(0).normal(size=16) * 0.03, side.scaled_outline(a)[1])[0], rel=1e-6
    )
    amplitudes, step = np.full(16, 0.01), 1e-7
    _, scale = again.scaled_outline(amplitudes)
    _, gradient, by_scale = again.energy(amplitudes, scale)
    total = gradient + again.by_amplitudes(
        again.scaled_outline(amplitudes)[0], scale, np.zeros((len(blob(1).points), 2)), by_scale
    )
    for mode in range(16):
        change = step * np.eye(16)[mode]
        above, below = (
            again.energy(amplitudes + s * change, again.scaled_outline(amplitudes + s * change)[1])[0] for s in (1, -1)
        )
        assert total[mode] == pytest.approx((above - below) / (2.0 * step), abs=1e-6)


@pytest.mark.parametrize(("seed_p", "seed_q"), [(1, 2), (4, 9), (7, 3)])
def test_bending_raises_the_bound_within_the_limits_of_strain(seed_p: int, seed_q: int) -> None:
    before, after = plans(seed_p, seed_q)[0], bent(seed_p, seed_q)
    assert after.plan.bound > before.bound + 0.005
    for bend in (after.p, after.q):
        assert bend.max_strain <= PARAMETERS.max_strain and bend.rms_strain <= PARAMETERS.rms_strain
        assert is_simple(bend.bent.points)
    assert after.worth > before.bound
    assert np.abs(edge_lengths(after.plan.trunk_p) - edge_lengths(after.plan.trunk_q)).max() < 1e-12
    assert after.plan.pair.p is after.p.bent and after.p.shape == before.pair.p


def test_a_bent_plan_gives_a_transform_as_good_as_its_bound() -> None:
    after = bent(1, 2)
    transform = construct_plan(after.plan, ConstructParameters())
    assert min(transform.overlap_ratios) > after.plan.bound - 0.01
    assert transform.p is after.p.bent


def test_bending_does_not_depend_on_how_often_it_is_done() -> None:
    again = bend_plan(plans(1, 2)[0], elastic(1), elastic(2), PARAMETERS)
    assert again.p == bent(1, 2).p and again.plan.trunks.tobytes() == bent(1, 2).plan.trunks.tobytes()


def test_the_greater_the_weight_the_less_shapes_bend() -> None:
    strains: list[float] = []
    for weight in (0.1, 1.0, 100.0):
        after = bend_plan(plans(1, 2)[0], elastic(1), elastic(2), BendParameters(weight=weight))
        strains.append(max(after.p.rms_strain, after.q.rms_strain))
    assert strains[0] > strains[1] > strains[2]
    assert strains[2] < 0.01


def test_the_best_of_several_plans_comes_first() -> None:
    several = bend_plans(plans(4, 9), elastic(4), elastic(9), BendParameters(steps=16))
    assert [plan.worth for plan in several] == sorted((plan.worth for plan in several), reverse=True)
    assert len(several) == min(len(plans(4, 9)), PARAMETERS.sketched)


def test_exact_pairs_hardly_bend() -> None:
    for seed in (3, 8):
        pair = exact_pair(4, seed)
        p, q = pair_shapes(pair)
        trunks = p.from_source(pair.trunk_p), q.from_source(pair.trunk_q)
        plan = plan_pair(given_pair(p, q, *trunks, 0.1, REFINEMENT.reach))
        after = bend_plan(plan, modes(p, straight=1.0), modes(q, straight=1.0), PARAMETERS)
        assert after.plan.bound >= 0.9994
        assert max(after.p.max_strain, after.q.max_strain) < 1e-3


def test_the_map_of_a_bend_leads_there_and_back() -> None:
    bend = bent(1, 2).p
    points = bend.shape.points
    assert np.abs(bend.field.at(points) - bend.bent.points).max() < 1e-9
    inside = 0.9 * points
    assert np.abs(bend.field.back(bend.field.at(inside)) - inside).max() < 1e-9
    step = 1e-7
    for axis in range(2):
        change = step * np.eye(2)[axis]
        slope = (bend.field.at(inside + change) - bend.field.at(inside - change)) / (2.0 * step)
        within = np.abs(slope - bend.field.gradient(inside)[:, :, axis]).max(axis=1) < 1e-6
        assert within.mean() > 0.95  # but for points on an edge between triangles
    assert np.quantile(bend.field.strain(inside), 0.9) <= bend.max_strain


def test_a_bent_shape_has_unit_area_and_keeps_its_likeness() -> None:
    shape = blob(1)
    small = bend_shape(elastic(1), np.full(16, 0.005))
    assert small.bent.name == shape.name and len(small.bent.points) == len(shape.points)
    assert small.rms_strain == pytest.approx(0.02, rel=0.2)
    assert overlap_ratio(small.bent.points, shape.points) > 0.9
    assert bend_shape(elastic(1), np.zeros(16)).max_strain < 1e-7


def test_a_piece_that_reaches_over_another_edge_covers_it() -> None:
    square = np.array(
        [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]]
    )  # clockwise, as trunks are that arcs are swung into
    arcs = [np.stack([square[i], square[(i + 1) % 4]]) for i in range(4)]
    arcs[0] = np.array([[0.0, 0.0], [0.9, 0.5], [0.9, 1.2], [0.0, 1.0]])
    offsets = np.concatenate([[0], np.cumsum([len(arc) for arc in arcs])])
    cost, gradient, covered = contact_cost(np.concatenate(arcs), offsets, 0.15, 1.0)
    assert covered[1] > 0.6 and covered[[0, 2, 3]].max() < 0.05
    assert cost > 0.1 and np.isfinite(gradient).all()


def test_signed_distances_of_arcs() -> None:
    arcs = np.array([[0.0, 0.0], [0.5, 1.0], [1.0, 0.0]])
    points = np.array([[0.5, 0.4], [0.5, 2.0], [0.5, -0.5]])
    distances, edges, _ = nearest_arcs(points, np.zeros(3, np.int64), arcs, np.array([0, 3]))
    assert (np.sign(distances[:, 0]) == [-1, 1, 1]).all()
    assert distances[1, 0] == pytest.approx(1.0) and set(edges[:, 0]) <= {0, 1}


def test_straight_sides_stay_straight() -> None:
    square = Shape.from_polygon([(0, 0), (1, 0), (1, 1), (0, 1)], "square")
    other = blob(2)
    candidates, _ = plan_pairs(
        trunk_pairs(square, other, best_trunk_pairs(square, other, count=4), REFINEMENT.reach), REFINEMENT
    )
    plan = refine_best(candidates, REFINEMENT)[0]

    def sag(weight: float) -> float:
        parameters = BendParameters(straight=weight)
        after = bend_plan(plan, modes(square, straight=weight), modes(other, straight=weight), parameters)
        corners = np.flatnonzero(np.abs(np.abs(square.points).min(axis=1) - 0.5) < 1e-9)
        return max(
            float(np.abs((points[1:-1] - points[0]) @ [[0.0, -1.0], [1.0, 0.0]] @ (points[-1] - points[0])).max())
            for points in (
                after.p.bent.points[np.arange(start, stop + 1) % len(square.points)]
                for start, stop in zip(corners, np.append(corners[1:], corners[0] + len(square.points)), strict=True)
            )
        )

    assert sag(1.0) < 0.01
    assert sag(1.0) < 0.5 * sag(0.0)


def test_construct_bends_if_asked_and_else_changes_nothing() -> None:
    a, b = blob(1), blob(2)
    few = RefineParameters(candidates=4)
    unbent = construct(a, b, refinement=few)
    off = construct(a, b, refinement=few, bend=BendParameters())
    assert [piece.lower.tobytes() for piece in off.pieces] == [piece.lower.tobytes() for piece in unbent.pieces]
    assert (off.trunk_p == unbent.trunk_p).all() and off.bound_p == unbent.bound_p and off.p is a
    elastic_bend = construct(a, b, refinement=few, bend=BendParameters(method="elastic"))
    assert elastic_bend.certificate().passed
    assert min(elastic_bend.overlap_ratios) > min(unbent.overlap_ratios) + 0.005
    assert overlap_ratio(elastic_bend.p.points, a.points) > 0.8


def test_a_folded_interior_is_seen() -> None:
    side = BentSide.unbent(elastic(1), blob(1).points)
    assert side.is_unfolded(np.full(16, 0.01))
    assert not side.is_unfolded(np.full(16, 2.0))

"""The benchmark of bent trunks measures what it says: its bound is the library's, and it sees what bends give away."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
import shapely

from riot.groundtruth.pairs import exact_pair, exact_transform
from riot.kernels.change import least_changes

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
from bent_trunks import Bent, bound, changes, plan_of, show


def test_without_bends_the_bound_is_the_librarys() -> None:
    plan = plan_of(exact_transform(exact_pair(4, 3)))
    rng = np.random.default_rng(0)
    moved = plan.trunks + rng.normal(0.0, 0.02, plan.trunks.shape)
    ours, _ = least_changes(*plan.pair.windowed_outlines, moved, 256)
    straight = bound(plan.pair, moved, np.zeros((4, 0)))
    assert straight == pytest.approx(float(ours.min()), abs=2e-3)
    assert straight < 0.999
    assert bound(plan.pair, moved, np.zeros((4, 2))) == pytest.approx(straight, abs=1e-12)


def test_a_bend_that_a_piece_does_not_hold_costs_what_it_gives_away() -> None:
    plan = plan_of(exact_transform(exact_pair(4, 3)))
    assert bound(plan.pair, plan.trunks, np.zeros((4, 1))) > 0.998
    # An exact dissection stays one while its pieces hold the bent edges, and no longer.
    assert bound(plan.pair, plan.trunks, np.full((4, 1), 0.002)) > 0.998
    assert bound(plan.pair, plan.trunks, np.full((4, 1), 0.5)) < 0.98


def test_areas_lost_and_added_are_those_of_overlay() -> None:
    target = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]])
    arc = np.array([[-0.5, -0.25], [1.25, 0.0], [1.0, 0.75]])
    other = np.array([[0.75, 0.25], [1.75, 0.5], [1.0, 1.5]])
    a, b, whole = (shapely.Polygon(polygon) for polygon in (arc, other, target))
    lost, added = changes(np.concatenate([arc, other]), np.array([0, 3, 6]), target, 20_000)
    overlaps = a.intersection(b).intersection(whole).area
    assert lost == pytest.approx(overlaps + a.difference(whole).area + b.difference(whole).area, abs=1e-4)
    assert added == pytest.approx(whole.difference(a.union(b)).area, abs=1e-4)


def test_the_table_tells_gains_on_the_control(capsys: pytest.CaptureFixture[str]) -> None:
    bounds = {"straight, convex": 0.95, "straight": 0.95, "one bend": 0.9625, "two bends": 0.95}
    show([Bent("a", "b", 4, 0.9375, bounds)])
    printed = capsys.readouterr().out
    assert "+0.01250" in printed
    assert "-0.01250" in printed

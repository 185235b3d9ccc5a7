"""Edits of a transform that is made: its plan comes back, corners move, lines are joined, and errors say where."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import shapely

from riot import Shape, TrunkError, construct
from riot.construction.dissected_plan import DissectedPlan, dissect_plan
from riot.construction.drawn_lines import Side, add_line, pull
from riot.construction.line_over_hinges import draw_stretch
from riot.construction.pins import Pins, draw
from riot.construction.plan_transform import construct_plan
from riot.construction.replan import plan_of, trunks_of, unbent_plan, with_corner
from riot.construction.tuning import LEAF_RADIUS, PIN_TOLERANCE
from riot.errors import PinError
from riot.parameters import BendParameters, ConstructParameters
from riot.transform.transform import Transform
from riot.types import FloatArray
from riot.units import L_C

LINES = 512


@cache
def made(bent: bool = False) -> Transform:
    house = Shape.from_polygon([(0, 0), (4, 0), (4, 3), (2, 5), (0, 3)], name="house")
    kite = Shape.from_polygon([(0, 3), (-2, 0), (0, -2), (2, 0)], name="kite")
    bend = BendParameters(method="elastic", steps=8) if bent else None
    return construct(house, kite, bend=bend)


@cache
def dissected(bent: bool = False) -> DissectedPlan:
    return dissect_plan(plan_of(made(bent)), ConstructParameters())


def apart(points: FloatArray, outline: FloatArray) -> FloatArray:
    return np.asarray(shapely.distance(shapely.points(points), shapely.LinearRing(outline)))


def middle_of_an_arc(transform: Transform) -> FloatArray:
    """A point of P's outline that is far from every hinge."""
    outline = transform.outline_p()
    away = np.hypot(*(outline[:, None] - transform.trunk_p[None]).transpose(2, 0, 1)).min(axis=1)
    return np.asarray(outline[away.argmax()])


@pytest.mark.parametrize("side", ["p", "q"])
@pytest.mark.parametrize("height", [0.0, 0.015])
def test_a_line_over_a_hinge_is_led_through_it_and_what_contradicts_it_is_told(side: Side, height: float) -> None:
    transform = dissected().transform()
    outline = shapely.LinearRing(transform.outline_p() if side == "p" else transform.outline_q())
    hinges = transform.pose(0.0 if side == "p" else 1.0).origins
    drawn = 0
    for hinge in hinges:
        around = outline.project(shapely.Point(hinge)) + np.linspace(-0.1, 0.25, 36)
        line = shapely.get_coordinates(shapely.line_interpolate_point(outline, around % outline.length))
        ahead = line[-1] - line[0]
        normal = np.array([ahead[1], -ahead[0]]) / np.hypot(*ahead)
        line += height * np.sin(np.linspace(0.0, np.pi, len(line)))[:, None] * normal
        try:
            stretch = draw_stretch(dissected(), side, Pins(), line)
        except PinError as error:
            assert error.side == side and len(error.points) > 0
            continue
        drawn += 1
        assert (len(stretch.lost) == 0) == (stretch.reason == "")
        edited = dissected().transform(stretch.pins)
        new = edited.outline_p() if side == "p" else edited.outline_q()
        assert edited.certificate().passed and apart(hinges, new).max() < 1e-12
        for pin in stretch.pins.p or stretch.pins.q:
            clear = np.hypot(*(pin.points[:, None] - hinges[None]).transpose(2, 0, 1)).min(axis=1) > LEAF_RADIUS * L_C
            assert apart(pin.points[clear], new).max() <= PIN_TOLERANCE
    assert drawn


def test_a_line_that_leaves_out_a_hinge_is_told_to_go_through_it() -> None:
    outline = dissected().transform().outline_p()
    with pytest.raises(PinError, match="leaves out a hinge") as caught:
        draw_stretch(dissected(), "p", Pins(), outline[[len(outline) // 8, len(outline) // 2]])
    hinges = dissected().transform().pose(0.0).origins
    assert (
        np.hypot(*(np.array(caught.value.points)[:, None] - hinges[None]).transpose(2, 0, 1)).min(axis=1).max() < 1e-9
    )


@pytest.mark.parametrize("bent", [False, True])
def test_the_plan_of_a_transform_makes_it_again(bent: bool) -> None:
    again = construct_plan(plan_of(made(bent)), ConstructParameters())
    assert np.abs(trunks_of(again) - trunks_of(made(bent))).max() < 1e-12
    for outline, other in (
        (again.outline_p(), made(bent).outline_p()),
        (again.outline_q(), made(bent).outline_q()),
    ):
        assert apart(outline, other).max() < 1e-6
    assert (again.bend_p is None) == (not bent)


def test_a_corner_goes_along_the_outline_and_the_trunks_stay_conjugate() -> None:
    plan = plan_of(made())
    outline = made().p.points
    to = outline[(np.hypot(*(outline - plan.feet[0, 1]).T).argmin() + 2) % len(outline)]
    moved = with_corner(plan, "p", 1, to, LINES)
    assert np.hypot(*(moved.pair.corners[0, 1] - to)) < 1e-9
    edges_p, edges_q = (np.hypot(*(np.roll(trunk, -1, axis=0) - trunk).T) for trunk in moved.trunks)
    assert edges_p == pytest.approx(edges_q, abs=1e-9)


def test_a_corner_passes_no_other() -> None:
    plan = plan_of(made())
    with pytest.raises(TrunkError, match="pass the next one"):
        with_corner(plan, "p", 1, plan.feet[0, 2], LINES)
    with pytest.raises(TrunkError, match="no corner 9"):
        with_corner(plan, "p", 9, plan.feet[0, 2], LINES)


def test_before_the_bend_the_corners_are_at_the_same_places_of_the_inputs() -> None:
    plan = plan_of(made(bent=True))
    before = unbent_plan(plan, LINES)
    assert before.pair.p is made(bent=True).input_p
    bend = plan.pair.bend_p
    assert bend is not None
    assert np.abs(bend.field.at(before.pair.corners[0]) - plan.feet[0]).max() < 1e-3


@pytest.mark.parametrize("size", [0.01, -0.01])
def test_a_pull_moves_the_point_and_leaves_the_rest(size: float) -> None:
    at = middle_of_an_arc(made())
    to = at * (1.0 + size / np.hypot(*at))
    pins = pull(dissected(), "p", (), at, to, 0.1)
    after = dissected().transform(Pins(p=pins)).outline_p()
    before = dissected().transform().outline_p()
    assert apart(to[None], after)[0] < 1e-4
    # Beside the point only the piece across its cut gives way, wherever that lies around the outline.
    assert (apart(before, after) < 1e-4).mean() > 0.6


def test_a_second_pull_on_one_piece_is_joined_with_the_first() -> None:
    at = middle_of_an_arc(made())
    first = pull(dissected(), "p", (), at, at * 1.01, 0.08)
    beside = first[0].points[-2]
    second = pull(dissected(), "p", first, beside, beside * 1.01, 0.04)
    assert len(second) == 1
    outline = dissected().transform(Pins(p=second)).outline_p()
    assert apart((beside * 1.01)[None], outline)[0] < 1e-4
    assert apart((at * 1.01)[None], outline)[0] < 2e-3


def test_a_line_that_leaves_the_trunk_says_where() -> None:
    at = middle_of_an_arc(made())
    with pytest.raises(PinError) as caught:
        add_line(dissected(), "p", (), pull(dissected(), "p", (), at, at, 0.1)[0].points + 5.0)
    assert caught.value.reason == "pins"
    line = pull(dissected(), "p", (), at, at, 0.1)[0].points.copy()
    line[len(line) // 2] += 9.0
    with pytest.raises(PinError, match="leaves the trunk") as caught:
        dissected().transform(Pins(p=(draw(line),)))
    assert caught.value.side == "p" and caught.value.pin == 0
    assert np.abs(np.array(caught.value.points) - line[len(line) // 2]).max() < 1e-6

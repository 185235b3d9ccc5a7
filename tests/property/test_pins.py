"""Pins: kept and drawn stretches are met, the certificate passes, nothing else moves far (theory §8)."""

from __future__ import annotations

import contextlib
import importlib
import itertools
import json
from functools import cache
from unittest import mock

import numpy as np
import pytest
import shapely
from blobs import blob

from riot import ConstructionError, FormatError, Shape, construct
from riot.construction.dissected_plan import DissectedPlan, dissect_plan
from riot.construction.pinned_stretch import keep_stretch
from riot.construction.pins import Pin, Pins, draw, keep, load_pins, pins_from_json
from riot.construction.plan import ConstructionPlan
from riot.construction.tuning import LEAF_RADIUS, PIN_TOLERANCE
from riot.errors import PinError
from riot.parameters import ConstructParameters
from riot.scores.crs import best_trunk_pairs
from riot.types import FloatArray
from riot.units import L_C


@cache
def blob_draft() -> DissectedPlan:
    """Of two blobs that are no exact pair."""
    a, b = blob(1), blob(2)
    drafts: list[DissectedPlan] = []

    def record(plan: ConstructionPlan, parameters: ConstructParameters) -> DissectedPlan:
        drafts.append(dissect_plan(plan, parameters))
        return drafts[-1]

    with mock.patch.object(importlib.import_module("riot.construction.plan_transform"), "dissect_plan", record):
        for score in best_trunk_pairs(a, b, count=16):
            with contextlib.suppress(ConstructionError):
                construct(a, b, (a.points[score.trunk_a], b.points[score.trunk_b]))
                return drafts[-1]
    raise AssertionError("no trunk pair of the two blobs can be constructed on")


def sections(shape: Shape, trunk: FloatArray, length: int) -> list[FloatArray]:
    """Runs of ``length`` outline points that stay clear of the trunk's vertices."""
    runs = []
    for start in range(0, len(shape.points), length):
        run = shape.points[np.arange(start, start + length) % len(shape.points)]
        if np.hypot(*(run[:, None] - trunk[None]).transpose(2, 0, 1)).min() > 1.5 * LEAF_RADIUS * L_C:
            runs.append(run)
    return runs


def apart(points: FloatArray, outline: FloatArray) -> float:
    return float(shapely.distance(shapely.points(points), shapely.LinearRing(outline)).max())


@cache
def moved_most() -> FloatArray:
    """The run of P's outline that is missed by most, of those whose piece keeps it inside the trunk it swings into."""
    draft = blob_draft()
    transform = draft.transform()
    for run in sorted(sections(transform.p, transform.trunk_p, 6), key=lambda run: -apart(run, transform.outline_p())):
        with contextlib.suppress(ConstructionError):
            draft.transform(Pins(p=(keep(run),)))
            return run
    raise AssertionError("no section of the blob can be kept")


def test_a_kept_stretch_is_met_and_was_not_before() -> None:
    draft = blob_draft()
    free = draft.transform()
    run = moved_most()
    transform = draft.transform(Pins(p=(keep(run),)))
    assert transform.certificate().passed
    assert apart(run, free.outline_p()) > 10.0 * PIN_TOLERANCE
    assert apart(run, transform.outline_p()) <= PIN_TOLERANCE
    # Q's outline lives in the other tree.
    for first, second in zip(transform.pieces, free.pieces, strict=True):
        assert np.array_equal(first.upper, second.upper)


def test_pins_of_both_shapes_are_met_together() -> None:
    draft = blob_draft()
    transform = draft.transform()
    run_p = moved_most()
    run_q = min(sections(transform.q, transform.trunk_q, 4), key=lambda run: apart(run, transform.outline_q()))
    transform = draft.transform(Pins((keep(run_p),), (keep(run_q),)))
    assert transform.certificate().passed
    assert apart(run_p, transform.outline_p()) <= PIN_TOLERANCE
    assert apart(run_q, transform.outline_q()) <= PIN_TOLERANCE


def test_a_kept_point_keeps_the_boundary_around_it() -> None:
    draft = blob_draft()
    point = moved_most()[3]
    assert apart(point[None], draft.transform(Pins(p=(keep(point),))).outline_p()) <= PIN_TOLERANCE


def test_the_order_of_a_stretch_does_not_matter() -> None:
    draft = blob_draft()
    run = moved_most()
    first, second = (draft.transform(Pins(p=(keep(points),))) for points in (run[[0, -1]], run[[-1, 0]]))
    assert np.array_equal(first.outline_p(), second.outline_p())


@pytest.mark.parametrize("length", [12, 40])
def test_a_stretch_is_kept_as_far_as_the_trunk_has_room_and_the_rest_is_told(length: int) -> None:
    draft = blob_draft()
    shapes = {"p": draft.plan.pair.p, "q": draft.plan.pair.q}
    whole = partly = 0
    for side, start in itertools.product("pq", range(0, len(shapes["p"].points), length)):
        shape = shapes[side]
        run = shape.points[np.arange(start, start + length) % len(shape.points)]
        try:
            stretch = keep_stretch(draft, side, Pins(), run)
        except PinError as error:
            assert error.side == side and apart(np.array(error.points), shape.points) < 1e-6
            continue
        assert (len(stretch.lost) == 0) == (stretch.reason == "")
        whole += stretch.reason == ""
        partly += stretch.reason != ""
        transform = draft.transform(stretch.pins)
        assert transform.certificate().passed
        outline, hinges = getattr(transform, f"outline_{side}")(), getattr(transform, f"trunk_{side}")
        kept = np.concatenate([pin.points for pin in getattr(stretch.pins, side)])
        clear = np.hypot(*(kept[:, None] - hinges[None]).transpose(2, 0, 1)).min(axis=1) > LEAF_RADIUS * L_C
        assert apart(kept[clear], outline) <= PIN_TOLERANCE
        # Every point that was asked for is kept, or told to be lost.
        both = shapely.MultiPoint(np.concatenate([kept, stretch.lost]))
        assert shapely.distance(both, shapely.points(run)).max() < 1e-6
    assert whole and partly


def test_a_pin_of_before_is_not_given_up_for_a_stretch() -> None:
    draft = blob_draft()
    first = keep(moved_most())
    shape = draft.plan.pair.p
    stretch = keep_stretch(draft, "p", Pins(p=(first,)), shape.points[: len(shape.points) // 3])
    assert stretch.pins.p[0] is first
    assert apart(first.points, draft.transform(stretch.pins).outline_p()) <= PIN_TOLERANCE


def bump(run: FloatArray, height: float) -> FloatArray:
    """A line over a section of the outline, ``height`` off its middle."""
    ahead = run[-1] - run[0]
    normal = np.array([ahead[1], -ahead[0]]) / np.hypot(*ahead)
    return np.array([run[0], run[len(run) // 2] + height * normal, run[-1]])


@pytest.mark.parametrize("height", [0.01, -0.01])
def test_a_drawn_line_replaces_the_outline(height: float) -> None:
    draft = blob_draft()
    line = bump(moved_most(), height)
    transform = draft.transform(Pins(p=(draw(line),)))
    assert transform.certificate().passed
    even = shapely.line_interpolate_point(shapely.LineString(line), np.linspace(0.0, 1.0, 20), normalized=True)
    assert shapely.distance(even, shapely.LinearRing(transform.outline_p())).max() <= PIN_TOLERANCE


def test_without_pins_nothing_changes() -> None:
    draft = blob_draft()
    for first, second in zip(draft.transform(Pins()).pieces, draft.transform().pieces, strict=True):
        assert np.array_equal(first.polygon, second.polygon)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda run, shape: keep([3.0, 3.0]), "lies .* from the outline"),
        (lambda run, shape: draw(shape.points[[0, len(shape.points) // 2]]), "hinge is between its ends"),
        (lambda run, shape: draw(bump(run, -9.0)), "leaves the trunk|crosses the outline"),
    ],
)
def test_what_cannot_be_pinned_is_refused_with_the_reason(change: object, words: str) -> None:
    draft = blob_draft()
    run = moved_most()
    with pytest.raises(ConstructionError, match=words) as caught:
        draft.transform(Pins(p=(change(run, draft.plan.pair.p),)))  # type: ignore[operator]
    assert caught.value.reason == "pins"
    assert "pin 0 of blob-1" in str(caught.value)


def text(**changes: object) -> str:
    document = {"format": "riot-pins", "version": 1, "frame": "source", "p": [{"keep": [[1.0, 2.0]]}], "q": []}
    return json.dumps({**document, **changes})


def test_a_pins_file_is_read_in_the_sources_coordinates(tmp_path: object) -> None:
    p, q = blob(1), blob(2)
    path = tmp_path / "pins.json"  # type: ignore[operator]
    line = [[0.0, 1.0], [2.0, 3.0]]
    path.write_text(text(q=[{"draw": line}]), encoding="utf-8")
    pins = load_pins(path, p, q)
    assert p.source(pins.p[0].points) == pytest.approx(np.array([[1.0, 2.0]]))
    assert q.source(pins.q[0].points) == pytest.approx(np.array(line))
    assert pins.q[0].drawn
    assert not pins.p[0].drawn
    in_frame = pins_from_json(text(frame="shape"), p, q)
    assert np.array_equal(in_frame.p[0].points, [[1.0, 2.0]])


@pytest.mark.parametrize(
    ("written", "words"),
    [
        ("{", "not JSON"),
        ("[1]", '"format": "riot-pins"'),
        (text(version=2), "version"),
        (text(frame="pixels"), "source"),
        (text(r=[]), '"r" means nothing'),
        (text(p={}), "not a list"),
        (text(p=[{"hold": []}]), "pin 0 of p"),
        (text(p=[{"keep": [[1, "a"]]}]), "pin 0 of p"),
        (text(q=[{"draw": [[1, 2]]}]), "at least 2"),
    ],
)
def test_a_wrong_pins_file_is_refused_with_what_to_do(written: str, words: str) -> None:
    with pytest.raises(FormatError, match=words):
        pins_from_json(written, blob(1), blob(2), "pins.json")


def test_a_pin_of_no_points_is_refused() -> None:
    for points, drawn in ((np.zeros((0, 2)), False), (np.zeros((1, 2)), True), (np.array([[np.nan, 0.0]]), False)):
        with pytest.raises(ValueError, match="finite"):
            Pin(points, drawn)

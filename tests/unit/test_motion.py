"""Motion plans of exact pairs: free of collision, hinges hold, ends are the closed chains, lifts only where needed."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations, pairwise

import numpy as np
import numpy.typing as npt
import pytest
import shapely

from riot import FormatError, Transform
from riot.groundtruth.pairs import dudeney, exact_pair, exact_transform
from riot.motion import Motion, MotionParameters, plan_motion
from riot.motion.search import Subchain, find_path
from riot.transform.pose import direction
from riot.transform.riot_file import from_json, to_json
from riot.transform.transform import Piece
from riot.types import FloatArray

KNOB = np.array([0, 0.45, 0.45 + 0.06j, 0.35 + 0.06j, 0.35 + 0.14j, 0.65 + 0.14j, 0.65 + 0.06j, 0.55 + 0.06j, 0.55, 1])
"""An arc from 0 to 1 with the head of a T on it: two pieces that share it are locked like those of a jigsaw puzzle."""

TAB = np.array([0, 0.42, 0.42 + 0.2j, 0.58 + 0.2j, 0.58, 1])
"""The same with a straight tab: the two pieces cannot turn at their hinge, but can slide apart if that is open."""


def locked(hinges: Sequence[int], bump: npt.NDArray[np.complex128] = KNOB) -> Transform:
    """A transform of four pieces of which those that meet at some hinges cannot turn there."""
    transform = exact_transform(exact_pair(4, 3, curved=False, topology="star"))
    n = len(transform)
    lowers = []
    for i, piece in enumerate(transform.pieces):
        start, centre, end = piece.lower
        first = bumped(start, centre, bump) if i in hinges else np.array([start, centre])
        last = bumped(end, centre, bump)[::-1] if (i + 1) % n in hinges else np.array([centre, end])
        lowers.append(np.concatenate([first[:-1], last]))
    pieces = tuple(Piece(p.length, lower, p.upper) for p, lower in zip(transform.pieces, lowers, strict=True))
    return replace(transform, pieces=pieces)


def bumped(start: FloatArray, end: FloatArray, bump: npt.NDArray[np.complex128]) -> FloatArray:
    numbers = complex(*start) + complex(*(end - start)) * bump
    points = np.stack([numbers.real, numbers.imag], axis=1)
    points[0], points[-1] = start, end
    return points


MADE = {
    "dudeney": lambda: exact_transform(dudeney()),
    "star": lambda: exact_transform(exact_pair(3, 1)),
    "curved": lambda: exact_transform(exact_pair(5, 2)),
    "six": lambda: exact_transform(exact_pair(6, 5)),
    "tab": lambda: locked([1], TAB),
    "locked once": lambda: locked([2]),
    "locked twice": lambda: locked([1, 2]),
    "locked thrice": lambda: locked([0, 1, 3]),
}


@pytest.fixture(scope="module", params=MADE, ids=str)
def planned(request: pytest.FixtureRequest) -> Transform:
    return MADE[request.param]().planned()


def plan(transform: Transform) -> Motion:
    assert transform.plan is not None
    return transform.plan


def test_ends_are_the_closed_chains(planned: Transform) -> None:
    motion = plan(planned)
    for t, closed in ((0.0, planned.pose(0.0)), (1.0, planned.pose(1.0))):
        assert np.array_equal(motion.pose_at(t).origins, closed.origins)
        assert np.exp(1j * motion.pose_at(t).headings) == pytest.approx(np.exp(1j * closed.headings), abs=1e-14)
        beyond = motion.pose_at(t + (t - 0.5) * 1e-9)
        assert np.array_equal(beyond.origins, closed.origins)


def test_the_motion_does_not_jump(planned: Transform) -> None:
    motion = plan(planned)
    times = np.unique(np.concatenate([np.linspace(0.0, 1.0, 801), motion.times, [1e-12, 1.0 - 1e-12]]))
    poses = [motion.pose_at(float(t)) for t in times]
    for before, after in pairwise(poses):
        passed = after.t - before.t
        assert np.abs(after.headings - before.headings).max() < 1e-9 + 60.0 * passed
        assert np.abs(after.origins - before.origins).max() < 1e-9 + 60.0 * passed


def test_hinges_hold_in_every_pose(planned: Transform) -> None:
    motion, n = plan(planned), len(planned)
    for t in np.linspace(0.0, 1.0, 41):
        pose = motion.pose_at(float(t))
        for j in set(range(n)) - {motion.open_hinge}:
            i = (j - 1) % n
            end = pose.origins[i] + planned.pieces[i].length * direction(float(pose.headings[i]))
            assert np.abs(end - pose.origins[j]).max() < 1e-12


def test_no_two_shrunk_pieces_of_one_plane_meet(planned: Transform) -> None:
    motion, n = plan(planned), len(planned)
    shrunk = [shapely.Polygon(piece.polygon).buffer(-0.5 * motion.gap) for piece in planned.pieces]
    discs = [[shapely.Point(x, 0.0).buffer(motion.relief) for x in (0.0, piece.length)] for piece in planned.pieces]
    for t in np.linspace(0.0, 1.0, 200):
        pose, level = motion.pose_at(float(t)), motion.levels_at(float(t))

        def body(i: int, relieved: int | None, pose=pose) -> shapely.Geometry:  # type: ignore[no-untyped-def]
            whole = shrunk[i] if relieved is None else shrunk[i].difference(discs[i][relieved])
            return shapely.transform(whole, lambda points: pose.place(i, points))

        for i, k in combinations(range(n), 2):
            if level[i] != level[k]:
                continue
            ends: tuple[int | None, int | None] = (None, None)
            if k == i + 1 and k != motion.open_hinge:
                ends = (1, 0)
            elif (i, k) == (0, n - 1) and motion.open_hinge != 0:
                ends = (0, 1)
            assert not body(i, ends[0]).intersects(body(k, ends[1])), (t, i, k)


def test_lifted_pieces_rise_before_they_swing_and_lower_after(planned: Transform) -> None:
    motion, n = plan(planned), len(planned)
    assert not motion.levels[[0, -1]].any()
    assert len(set(motion.levels.max(axis=0))) == len(motion.lifted) + 1
    if not motion.flat:
        assert np.array_equal(motion.turns[0], motion.turns[1])
        assert np.array_equal(motion.turns[-1], motion.turns[-2])
    # One more plane after each lifting hinge, the open hinge aside.
    steps = {h for h in range(n) if motion.levels[1:-1, h].any() and h != motion.open_hinge}
    up = {h for h in steps if motion.levels[1, h] == motion.levels[1, h - 1] + 1}
    assert up == set(motion.lifted)


def test_the_file_keeps_the_plan(planned: Transform) -> None:
    again = from_json(to_json(planned))
    assert to_json(again) == to_json(planned)
    first, second = plan(planned), plan(again)
    assert first.tried == second.tried
    assert (first.words, first.search, first.open_hinge, first.checks) == (
        second.words,
        second.search,
        second.open_hinge,
        second.checks,
    )
    assert np.array_equal(first.pose_at(0.3).origins, second.pose_at(0.3).origins)
    assert again.motion() is again.plan


@pytest.mark.parametrize("name", ["dudeney", "star", "tab"])
def test_what_can_swing_flat_does(name: str) -> None:
    transform = MADE[name]()
    assert transform.certificate().passed
    motion = transform.motion()
    assert motion.flat
    assert motion.words == "swings flat"
    assert transform.motion() is motion


def test_a_tab_slides_out_of_the_open_hinge() -> None:
    motion = locked([1], TAB).motion()
    assert (motion.flat, motion.open_hinge, motion.search) == (True, 1, "sampled")


@pytest.mark.parametrize(
    ("hinges", "words"),
    [([2], "needs 1 telescopic hinge"), ([1, 2], "needs 1 telescopic hinge"), ([0, 1, 3], "needs 2 telescopic hinges")],
)
def test_locked_hinges_open_or_lift(hinges: list[int], words: str) -> None:
    transform = locked(hinges)
    assert transform.certificate().passed
    motion = transform.motion()
    assert motion.words == words
    assert {motion.open_hinge, *motion.lifted} >= set(hinges)
    # Why: each locked hinge was tried by itself.
    stuck = {(attempt.first + 1) % 4 for attempt in motion.tried if attempt.pieces == 2 and not attempt.free}
    assert stuck == set(hinges)
    assert motion.checks >= len(motion.tried) > 0


def test_a_lock_only_counts_with_less_play_than_it_is_high() -> None:
    transform = locked([1, 2])
    assert plan_motion(transform, MotionParameters(gap=1e-3)).lifted
    assert plan_motion(transform, MotionParameters(gap=0.1)).flat


def test_planning_is_deterministic() -> None:
    for make in (MADE["six"], MADE["locked twice"]):
        assert to_json(make().planned()) == to_json(make().planned())


def test_every_search_finds_a_way_where_all_are_free() -> None:
    from riot.motion.bodies import make_bodies
    from riot.transform.motion import SEARCHES

    transform = exact_transform(dudeney())
    bodies = make_bodies(transform, MotionParameters())
    hinge = transform.motion().open_hinge
    pieces = (hinge + np.arange(4)) % 4
    start, goal = (transform.chain.turns(t)[pieces[1:]] for t in (0.0, 1.0))
    for search in SEARCHES:
        subchain = Subchain(bodies, pieces, start, goal)
        path = find_path(subchain, search, 300, 0)
        assert path is not None
        assert np.array_equal(path[0], start)
        assert np.array_equal(path[-1], goal)
        assert subchain.free(path)


def test_version_1_is_read_and_has_no_plan() -> None:
    transform = exact_transform(exact_pair(3, 1))
    text = to_json(transform)
    assert '"version":2' in text
    old = from_json(text.replace('"version":2', '"version":1'))
    assert old.plan is None
    assert np.array_equal(old.outline_p(), transform.outline_p())
    with pytest.raises(FormatError, match="version 4"):
        from_json(text.replace('"version":2', '"version":4'))


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("open_hinge",), 4),
        (("open_hinge",), 0.5),
        (("lifted",), [1, 1]),
        (("times", 0), 0.1),
        (("times", 1), -1.0),
        (("turns", 0), [1.0]),
        (("turns", 0, 0), math.nan),
        (("levels", 0, 0), 0.5),
        (("levels", 0, 0), -1),
        (("search",), "by luck"),
        (("gap",), -1.0),
        (("tried", 0), [1]),
    ],
)
def test_damaged_plans_are_refused(path: tuple[str | int, ...], value: object) -> None:
    document = json.loads(to_json(locked([1, 2]).planned()))
    container = document["motion"]
    for key in path[:-1]:
        container = container[key]
    container[path[-1]] = value
    with pytest.raises(FormatError, match="damaged"):
        from_json(json.dumps(document))

"""Pictures of exact pairs: what is in them, that they are well-formed, and that they are the same every time."""

import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from itertools import combinations, pairwise

import numpy as np
import pytest
from PIL import Image

from riot.draw import animate_svg, draw_transform
from riot.draw.figure import figure_scene
from riot.draw.keyframes import eased, frame_count, keyframes, motion_marks, swept_box
from riot.draw.palette import DARK, LIGHT, PENS, PIECES, colour, hue
from riot.draw.panels import chain_marks, pose_marks, sketch
from riot.draw.scene import PlacedPiece, around, extent, moved, placed
from riot.draw.svg import document
from riot.draw.svg_text import escape, path_data, turn
from riot.draw.tuning import FIGURE_TIMES, MAX_TURN, SKETCH_TOLERANCE, WAY_FRAMES
from riot.errors import RiotError
from riot.groundtruth.pairs import dudeney, exact_pair, exact_transform
from riot.motion import motion_of

SVG = "{http://www.w3.org/2000/svg}"

# Linear RGB as eyes without the middle and without the long cones see it (Machado et al. 2009, severity 1).
BLINDNESS = (
    np.eye(3),
    np.array([[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]),
    np.array([[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]),
)


@pytest.fixture(scope="module", params=[(3, 1), (4, 2), (6, 5)], ids=str)
def transform(request):
    exact = exact_transform(exact_pair(*request.param))
    return replace(exact, p=exact.p.renamed("Tête & <b>'1'</b>"), q=exact.q.renamed('"q"\x01'))


def oklab(text, seen):
    value = np.array([int(text[k : k + 2], 16) for k in (1, 3, 5)]) / 255.0
    linear = np.clip(seen @ np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4), 0.0, 1.0)
    cones = np.array([[0.4122, 0.5363, 0.0514], [0.2119, 0.6807, 0.1074], [0.0883, 0.2817, 0.6300]]) @ linear
    mix = np.array([[0.2105, 0.7936, -0.0041], [1.9780, -2.4286, 0.4506], [0.0259, 0.7828, -0.8087]])
    return mix @ np.cbrt(cones)


@pytest.mark.parametrize("seen", BLINDNESS, ids=["all", "no-middle", "no-long"])
def test_colours_stay_apart_for_colour_blind_eyes(seen):
    labs = [oklab(text, seen) for text in PIECES]
    for i, j in combinations(range(len(PIECES)), 2):
        neighbours = j - i == 1 or (i, j) == (0, len(PIECES) - 1)
        if neighbours or j < 5:
            assert np.linalg.norm(labs[i] - labs[j]) > 0.1, (i, j)


@pytest.mark.parametrize("n", range(3, 30))
def test_neighbours_in_the_chain_never_share_a_colour(n):
    assert all(hue(k, n) != hue((k + 1) % n, n) for k in range(n))


def test_every_pen_has_its_colours_in_both_schemes():
    for pen in PENS.values():
        for name in filter(None, (pen.fill, pen.stroke)):
            assert re.fullmatch("#[0-9a-f]{6}", colour(name, LIGHT))
            assert re.fullmatch("#[0-9a-f]{6}", colour(name, DARK))


def test_a_sketch_stays_within_its_tolerance(transform):
    for piece, thin in zip(transform.pieces, sketch(transform).pieces, strict=True):
        assert len(thin.polygon) <= len(piece.polygon)
        for arc, line in ((piece.lower, thin.lower), (piece.upper, thin.upper)):
            assert np.array_equal(arc[[0, -1]], line[[0, -1]])
            assert max(distance_to(line, point) for point in arc) <= SKETCH_TOLERANCE * 1.001


def distance_to(line, point):
    starts, steps = line[:-1], np.diff(line, axis=0)
    along = np.clip(((point - starts) * steps).sum(axis=1) / (steps**2).sum(axis=1), 0.0, 1.0)
    return np.linalg.norm(starts + along[:, None] * steps - point, axis=1).min()


def test_the_straight_chain_has_p_below_and_q_above(transform):
    placed_pieces = [mark for mark in chain_marks(transform, 1) if isinstance(mark, PlacedPiece)]
    assert all(placed_piece.y == 0.0 and placed_piece.heading == 0.0 for placed_piece in placed_pieces)
    assert sorted(placed_piece.piece for placed_piece in placed_pieces) == list(range(len(transform)))
    ends = sorted(
        (placed_piece.x, placed_piece.x + transform.pieces[placed_piece.piece].length) for placed_piece in placed_pieces
    )
    assert ends[0][0] == 0.0
    assert all(a[1] == pytest.approx(b[0]) for a, b in pairwise(ends))


def test_moving_marks_moves_what_they_show(transform):
    marks = pose_marks(transform, transform.pose(0.3), 0)
    before, after = marks[1], moved(marks, 2.0, -1.0, 0.5)[1]
    points = transform.pieces[1].polygon
    assert np.allclose(placed(after, points), 0.5 * placed(before, points) + [2.0, -1.0])


def test_a_figure_shows_every_piece_in_every_state(transform):
    root = ET.fromstring(document(figure_scene(transform)))
    n = len(transform)
    uses = [use.get("href") for use in root.iter(f"{SVG}use")]
    states = 2 + 1 + len(FIGURE_TIMES)  # two dissections, the chain, the poses
    assert len(uses) == n * states
    defined = [group.get("id") for group in root.find(f"{SVG}defs")]
    assert len(defined) == n
    assert all(uses.count(f"#{name}") == states for name in defined)


def test_trunk_edges_have_the_colours_of_their_pieces(transform):
    root = ET.fromstring(document(figure_scene(transform)))
    n = len(transform)
    used = [path.get("class") for path in root.iter(f"{SVG}path")]
    for k in range(n):
        assert used.count(f"r-piece{hue(k, n)}") == 1
        assert used.count(f"r-edge{hue(k, n)}") == 2  # once on P, once on Q


def test_marks_lie_within_the_figure(transform):
    scene = figure_scene(transform)
    x0, y0, x1, y1 = extent(scene.marks, scene.pieces)
    assert scene.box[0] <= x0 < x1 <= scene.box[2]
    assert scene.box[1] <= y0 < y1 <= scene.box[3]


@pytest.mark.parametrize("suffix", ["SVG", "png", "pdf"])
def test_a_figure_is_the_same_every_time(tmp_path, suffix):
    transform = exact_transform(exact_pair(4, 2))
    draw_transform(transform, tmp_path / f"a.{suffix}")
    draw_transform(transform, tmp_path / f"b.{suffix}")
    data = (tmp_path / f"a.{suffix}").read_bytes()
    assert data == (tmp_path / f"b.{suffix}").read_bytes()
    assert data.startswith({"svg": b"<svg ", "png": b"\x89PNG", "pdf": b"%PDF"}[suffix.lower()])


def test_a_png_has_the_colours_of_the_pieces(tmp_path):
    transform = exact_transform(exact_pair(5, 3))
    draw_transform(transform, tmp_path / "a.png")
    with Image.open(tmp_path / "a.png") as picture:
        frequent = {pixel for count, pixel in picture.convert("RGB").getcolors(1 << 20) if count > 2000}
    for k in range(5):
        assert tuple(bytes.fromhex(PIECES[k][1:])) in frequent


def test_an_empty_exterior_piece_can_be_drawn(tmp_path):
    transform = exact_transform(dudeney())
    draw_transform(transform, tmp_path / "dudeney.pdf")
    root = ET.fromstring(animate_svg(transform))
    assert root.tag == f"{SVG}svg"


@pytest.mark.parametrize("name", ["a.gif", "a", "a.svgz"])
def test_an_unknown_suffix_names_the_known_ones(tmp_path, name):
    transform = exact_transform(dudeney())
    with pytest.raises(ValueError, match=r"\.svg, \.png, \.pdf") as caught:
        draw_transform(transform, tmp_path / name)
    assert isinstance(caught.value, RiotError)
    assert not list(tmp_path.iterdir())


def test_names_are_text_not_markup(transform):
    for text in (document(figure_scene(transform)), animate_svg(transform)):
        root = ET.fromstring(text)
        assert "Tête & <b>'1'</b>" in root.find(f"{SVG}title").text
        assert not list(root.iter(f"{SVG}b"))
        assert "\x01" not in text


def test_escape_leaves_nothing_that_xml_forbids():
    text = "".join(map(chr, range(256))) + "\ud800\uffff"
    assert ET.fromstring(f"<a b='{escape(text)}'>{escape(text)}</a>").text.startswith("\N{REPLACEMENT CHARACTER}")
    escape(text).encode()


def test_path_data_reads_back_to_a_thousandth():
    points = np.random.default_rng(0).normal(size=(50, 2))
    numbers = np.array(re.findall(r"-?\d+", path_data(points)), dtype=float).reshape(-1, 2)
    assert np.abs(np.cumsum(numbers, axis=0) / 1000 * [1, -1] - points).max() <= 0.0005


def test_turns_are_short_and_clockwise():
    assert [turn(value) for value in (0.0, -0.0, -1e-9, np.pi / 2, -2 * np.pi - 1e-12)] == ["0", "0", "0", "-90", "0"]


@pytest.fixture(params=["as planned", "with stops", "with lifts"])
def motion(transform, request):
    """The plan; with stops at arbitrary turns, of which some are wide; and as if a hinge had to lift besides."""
    planned = motion_of(transform)
    if request.param == "as planned":
        return planned
    times, n, rng = np.array([0.0, 0.13, 0.4, 0.41, 1.0]), len(transform), np.random.default_rng(11)
    stops = [planned.turns_at(t) + rng.uniform(-3.0, 3.0, n) for t in times[1:-1]]
    turns = np.array([planned.turns[0], *stops, planned.turns[-1]])
    lifted = ((planned.open_hinge + 1) % n,) if request.param == "with lifts" else ()
    levels = np.zeros((5, n), dtype=np.int64)
    levels[1:-1, lifted] = 1
    return replace(planned, lifted=lifted, times=times, turns=turns, levels=levels)


class TestKeyframes:
    """All poses at once are those of `Motion.pose_at`, one by one."""

    @pytest.mark.parametrize("times", [eased(97), np.linspace(0.0, 1.0, 11), np.array([0.37]), np.array([1.0, 0.0])])
    def test_is_the_poses_one_by_one(self, motion, times):
        frames, poses = keyframes(motion, times), [motion.pose_at(float(t)) for t in times]
        assert np.allclose(frames.headings, [pose.headings for pose in poses], rtol=0.0, atol=1e-12)
        assert np.allclose(frames.origins, [pose.origins for pose in poses], rtol=0.0, atol=1e-12)

    def test_counts_the_frames_of_the_poses_one_by_one(self, motion):
        for least in (1, 10, WAY_FRAMES):
            fine = [motion.pose_at(float(t)).headings for t in eased(8 * least)]
            fastest = np.abs(np.diff(fine, axis=0)).max() * 8.0
            assert frame_count(motion, least) == max(least, int(np.ceil(least * fastest / MAX_TURN)))

    def test_its_frame_is_that_of_the_marks_of_every_pose(self, transform, motion):
        drawn, times = sketch(transform), eased(WAY_FRAMES)
        marks = [motion_marks(drawn, motion, float(t)) for t in times]
        plain = around((extent(marks_of_pose, drawn.pieces) for marks_of_pose in marks), 0.05)
        assert swept_box(drawn, keyframes(motion, times), 0.05) == pytest.approx(plain, rel=0.0, abs=1e-12)


class TestAnimation:
    def test_has_no_script_and_links_to_itself_only(self, transform):
        root = ET.fromstring(animate_svg(transform))
        names = {element.tag.removeprefix(SVG) for element in root.iter()}
        assert names <= {"svg", "title", "style", "rect", "defs", "g", "path", "use", "circle", "animateTransform"}
        ids = {f"#{element.get('id')}" for element in root.iter() if element.get("id")}
        assert {use.get("href") for use in root.iter(f"{SVG}use")} == ids

    def test_is_the_same_every_time(self, transform):
        assert animate_svg(transform) == animate_svg(transform)

    def test_key_frames_are_the_poses_and_hold_together(self, transform):
        frames, lengths = key_frames(transform)
        n = len(transform)
        for k in range(frames.shape[1]):
            x, y, degrees = frames[:, k].T
            ends = np.stack([x, y], axis=1) + lengths[:, None] * np.stack(
                [np.cos(np.radians(degrees)), np.sin(np.radians(degrees))], axis=1
            )
            gaps = [np.linalg.norm(ends[i] - [x[(i + 1) % n], y[(i + 1) % n]]) for i in range(n)]
            assert sorted(gaps)[-2] < 4e-3  # all but the open hinge

    def test_pieces_turn_little_between_frames(self, transform):
        frames, _ = key_frames(transform)
        assert np.abs(np.diff(frames[:, :, 2], axis=1)).max() < 15.0

    def test_loops_without_a_jump(self, transform):
        frames, _ = key_frames(transform)
        assert np.array_equal(frames[:, 0], frames[:, -1])

    def test_stays_within_the_view(self, transform):
        frames, _ = key_frames(transform)
        root = ET.fromstring(animate_svg(transform))
        left, top, wide, high = (float(value) / 1000 for value in root.get("viewBox").split())
        order = piece_order(root)
        fine = frames[:, :-1] + np.linspace(0, 1, 3)[:, None, None, None] * np.diff(frames, axis=1)
        for row, piece in enumerate(order):
            points = transform.pieces[piece].polygon
            for x, y, degrees in fine[:, row].reshape(-1, 3):
                angle = np.radians(-degrees)
                turned = points @ np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
                lain = turned + np.array([x, -y])
                low, high_ = lain.min(axis=0), lain.max(axis=0)
                assert left <= low[0] and high_[0] <= left + wide
                assert -(top + high) <= low[1] and high_[1] <= -top

    def test_has_a_still_picture_for_those_who_want_less_motion(self, transform):
        text = animate_svg(transform)
        assert "prefers-reduced-motion" in text
        still = ET.fromstring(text).findall(f"{SVG}g[@class='r-still']/{SVG}use")
        assert len(still) == len(transform)

    def test_easing_is_slow_at_both_ends_and_symmetric(self):
        times = eased(WAY_FRAMES)
        assert times[0] == 0.0 and times[-1] == 1.0
        assert np.all(np.diff(times) > 0)
        assert np.allclose(times + times[::-1], 1.0)


def piece_order(root):
    moving = root.find(f"{SVG}g[@class='r-move']")
    return [int(use.get("href").rsplit("-", 1)[1]) for use in moving.iter(f"{SVG}use")]


def key_frames(transform):
    """(n, frames, 3) x, y (downwards) and degrees of every piece in drawing order, and the lengths of their edges."""
    root = ET.fromstring(animate_svg(transform))
    motions = []
    for group in root.find(f"{SVG}g[@class='r-move']"):
        move, turn_ = group.iter(f"{SVG}animateTransform")
        places = np.array([pair.split() for pair in move.get("values").split(";")], dtype=float) / 1000
        turns = np.array(turn_.get("values").split(";"), dtype=float)
        assert move.get("dur") == turn_.get("dur") and len(places) == len(turns)
        motions.append(np.column_stack([places, turns]))
    return np.array(motions), np.array([transform.pieces[i].length for i in piece_order(root)])

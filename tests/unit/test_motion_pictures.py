"""Strips, animations and films show the plan."""

from __future__ import annotations

import importlib
import json
import re
import shutil
import subprocess
import xml.etree.ElementTree as ET
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from PIL import Image

from riot import RiotError, Transform
from riot.cli.main import main
from riot.draw import animate_svg, draw_strip, ffmpeg, write_film
from riot.draw.ffmpeg import MODULE, FilmError, write_mp4
from riot.draw.film_camera import Camera
from riot.draw.keyframes import eased, frame_count, loop_seconds, motion_marks, painting_order
from riot.draw.panels import sketch
from riot.draw.raster import pixels_of_png, png_bytes
from riot.draw.scene import Dot, PlacedPiece, extent
from riot.draw.strip import strip_scene
from riot.draw.tuning import LOOP_SECONDS, MAX_TURN, STRIP_POSES
from riot.errors import MissingExtraError
from riot.groundtruth.pairs import dudeney, exact_pair, exact_transform
from riot.motion import Motion, plan_motion
from riot.transform.motion import LIFT

SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module")
def transform() -> Transform:
    return exact_transform(exact_pair(4, 2)).planned()


def lifting(transform: Transform) -> Motion:
    """The made transform's motion as if hinge 2 had to lift."""
    flat = plan_motion(transform)
    high = [(2 - flat.open_hinge) % 4 <= (i - flat.open_hinge) % 4 for i in range(4)]
    levels = np.array([[0] * 4, high, high, [0] * 4], dtype=np.int64)
    turns = flat.turns[[0, 0, -1, -1]]
    return replace(flat, lifted=(2,), times=np.array([0.0, LIFT, 1.0 - LIFT, 1.0]), turns=turns, levels=levels)


def test_marks_are_the_poses_of_the_plan(transform: Transform) -> None:
    motion, drawn = transform.motion(), sketch(transform)
    for t in (0.0, 0.3, 1.0):
        pose = motion.pose_at(t)
        placed_pieces = [mark for mark in motion_marks(drawn, motion, t) if isinstance(mark, PlacedPiece)]
        assert sorted(placed_piece.piece for placed_piece in placed_pieces) == list(range(4))
        for placed_piece in placed_pieces:
            assert (placed_piece.x, placed_piece.y) == tuple(pose.origins[placed_piece.piece])
            assert placed_piece.heading == pose.headings[placed_piece.piece]


def test_higher_planes_are_painted_over_lower_ones(transform: Transform) -> None:
    motion = lifting(transform)
    top = motion.levels.max(axis=0)
    assert [top[i] for i in painting_order(motion)] == sorted(top)
    dots = [mark for mark in motion_marks(transform, motion, 0.5) if isinstance(mark, Dot)]
    assert [dot.pen for dot in dots].count("open") == 2
    assert len({dot.radius for dot in dots}) == 2


def test_frames_are_so_many_that_no_piece_turns_far_between_two(transform: Transform) -> None:
    for motion in (transform.motion(), exact_transform(dudeney()).motion()):
        frames = frame_count(motion, 10)
        turned = np.diff([motion.pose_at(float(t)).headings for t in eased(frames)], axis=0)
        assert frames >= 10
        assert np.abs(turned).max() < 1.1 * MAX_TURN


def test_animation_turns_the_pieces_as_the_plan_does(transform: Transform) -> None:
    root = ET.fromstring(animate_svg(transform))
    motion = transform.motion()
    frames = frame_count(motion)
    moving = root.find(f"{SVG}g[@class='r-move']")
    assert moving is not None
    for row, i in zip(moving, painting_order(motion), strict=True):
        _, rotation = row.iter(f"{SVG}animateTransform")
        assert float(rotation.get("dur", "")[:-1]) >= 0.99 * LOOP_SECONDS
        shown = {float(value) for value in rotation.get("values", "").split(";")}
        for t in eased(frames):
            angle = -np.degrees(motion.pose_at(float(t)).headings[i])
            assert min(abs(value - angle) for value in shown) < 0.06
    assert motion.words in (root.findtext(f"{SVG}title") or "")


def test_a_strip_shows_every_piece_in_every_pose(transform: Transform, tmp_path: Path) -> None:
    for suffix in ("svg", "png", "pdf"):
        for name in "ab":
            draw_strip(transform, tmp_path / f"{name}.{suffix}")
        assert (tmp_path / f"a.{suffix}").read_bytes() == (tmp_path / f"b.{suffix}").read_bytes()
    root = ET.fromstring((tmp_path / "a.svg").read_text(encoding="utf-8"))
    assert len(list(root.iter(f"{SVG}use"))) == 4 * STRIP_POSES
    assert any("swings flat" in (text.text or "") for text in root.iter(f"{SVG}text"))


def test_the_poses_of_a_strip_do_not_overlap(transform: Transform) -> None:
    scene = strip_scene(transform)
    placed_pieces = [mark for mark in scene.marks if isinstance(mark, PlacedPiece)]
    boxes = [extent(placed_pieces[4 * k : 4 * k + 4], scene.pieces) for k in range(STRIP_POSES)]
    assert all(before[2] < after[0] for before, after in pairwise(boxes))
    assert all(scene.box[1] < y0 < y1 < scene.box[3] for _, y0, _, y1 in boxes)
    assert scene.box[0] < boxes[0][0] and boxes[-1][2] < scene.box[2]


def test_a_gif_goes_there_and_back(transform: Transform, tmp_path: Path) -> None:
    for name in ("a.gif", "b.GIF"):
        write_film(transform, tmp_path / name, width=120)
    assert (tmp_path / "a.gif").read_bytes() == (tmp_path / "b.GIF").read_bytes()
    with Image.open(tmp_path / "a.gif") as film:
        frames = []
        for k in range(film.n_frames):  # type: ignore[attr-defined]
            film.seek(k)
            frames.append(np.asarray(film.convert("RGB"), dtype=np.int64))
        assert film.width == 120
        assert film.info["loop"] == 0
    turning = frame_count(transform.motion())
    assert len(frames) == 2 * turning
    differs = [np.abs(frames[0] - frame).mean() for frame in frames]
    assert max(differs) > 10.0
    assert np.abs(frames[3] - frames[-3]).mean() < 1.0  # the way back
    assert (frames[0] == 255).all(axis=2).mean() > 0.2  # paper


def test_an_mp4_needs_its_writer(transform: Transform, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    load = importlib.import_module

    def without_the_writer(name: str, package: str | None = None) -> ModuleType:
        if name == MODULE:
            raise ModuleNotFoundError(name=name)
        return load(name, package)

    monkeypatch.setattr(importlib, "import_module", without_the_writer)
    monkeypatch.setattr(ffmpeg.shutil, "which", lambda program: None)
    with pytest.raises(MissingExtraError, match=re.escape("riot-shapes[film]")) as caught:
        write_film(transform, tmp_path / "a.mp4")
    assert isinstance(caught.value, RiotError)
    # The command says so before it starts on the long work: it has not even looked for the pictures.
    assert main(["make", "a.png", "b.png", "-o", str(tmp_path / "out"), "--mp4"]) == 2
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(shutil.which("ffprobe") is None, reason="ffmpeg is not installed")
def test_an_mp4_is_a_film(transform: Transform, tmp_path: Path) -> None:
    for name in "ab":
        write_film(transform, tmp_path / f"{name}.mp4", width=121)
    command = ["ffprobe", "-v", "error", "-count_frames", "-show_streams", "-of", "json", str(tmp_path / "a.mp4")]
    (stream,) = json.loads(subprocess.run(command, capture_output=True, check=True).stdout)["streams"]
    assert (stream["codec_name"], stream["pix_fmt"], stream["width"]) == ("h264", "yuv420p", 120)
    assert int(stream["nb_read_frames"]) > 200
    seconds = loop_seconds(frame_count(transform.motion()))
    assert float(stream["duration"]) == pytest.approx(seconds, rel=0.01)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.mp4", "b.mp4"]
    assert (tmp_path / "a.mp4").read_bytes() == (tmp_path / "b.mp4").read_bytes()


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="ffmpeg is not installed")
def test_what_ffmpeg_says_is_told(tmp_path: Path) -> None:
    with pytest.raises(FilmError, match=r"ffmpeg could not write a\.mp4: .+"):
        write_mp4(tmp_path / "a.mp4", (3, 3), [Image.new("RGB", (3, 3))])  # odd sides
    assert not list(tmp_path.iterdir())


def test_a_film_shows_what_svg_does(transform: Transform) -> None:
    """Pillow's picture of a pose differs from resvg's at edges only: on few pixels, and by little on the whole."""
    camera = Camera(transform, 240, 1, {})
    scene = replace(camera._scene, marks=tuple(motion_marks(camera._drawn, camera.motion, 0.4)))
    fast, true = (
        np.asarray(picture, dtype=np.int64) for picture in (camera.picture(0.4), pixels_of_png(png_bytes(scene, 240)))
    )
    assert fast.shape == true.shape
    differs = np.abs(fast - true).max(axis=2)
    assert differs.mean() < 6.0 and (differs > 60).mean() < 0.03


@pytest.mark.parametrize("name", ["a.avi", "a", "a.png"])
def test_an_unknown_film_is_refused(transform: Transform, tmp_path: Path, name: str) -> None:
    with pytest.raises(ValueError, match=r"\.gif or \.mp4"):
        write_film(transform, tmp_path / name)
    assert not list(tmp_path.iterdir())

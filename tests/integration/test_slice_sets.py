"""`riot slices`: a small object becomes a stack of puzzles that read back as solids, in place, whole or not at all."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import manifold3d
import numpy as np
import pytest
import trimesh
from PIL import Image

from pipeline.datasets import sample
from pipeline.datasets.item import SAMPLE_PREFIX
from riot import Shape, Transform
from riot.cli.main import main
from riot.fabricate import FabricationParameters
from riot.slices import Cut, Model, ModelError, Puzzle, SliceOutcome, Stack, cut, make_puzzles, shortlists
from riot.slices.files import set_document, write_set
from riot.slices.picture import draw_overview, slices_scene

NAMES = ("card-heart", "polygon-square", "card-spade")
MADE, BAD, SOME_FAILED = 0, 2, 3


def egg() -> Model:
    """A pear on its side, with a pin's head on top that is too small to be made."""
    solid = manifold3d.Manifold.sphere(30.0, 40).scale((1.3, 1.0, 0.8)).translate((0.0, 0.0, 24.0))
    solid += manifold3d.Manifold.sphere(20.0, 40).translate((38.0, 0.0, 24.0))
    return Model("egg", solid + manifold3d.Manifold.cylinder(30.0, 7.0, 7.0, 24).translate((0.0, 0.0, 42.0)))


def low_egg() -> manifold3d.Manifold:
    """Without the pin's head."""
    return egg().solid.trim_by_plane((0.0, 0.0, -1.0), -44.0)


def counterparts() -> list[Shape]:
    return [sample.shape(f"{SAMPLE_PREFIX}{name}") for name in NAMES]


Done = tuple[Stack, tuple[SliceOutcome, ...], Path]


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> Done:
    stack = cut(egg(), Cut(3, 24.0, along="z"))
    outcomes = make_puzzles(stack, lambda slices: shortlists(slices, counterparts(), 3), distinct=True)
    folder = tmp_path_factory.mktemp("slices") / "set"
    write_set(stack, outcomes, folder)
    return stack, outcomes, folder


def puzzles(done: Done) -> list[tuple[SliceOutcome, Puzzle]]:
    return [(outcome, outcome.puzzle) for outcome in done[1] if outcome.puzzle is not None]


def test_a_slice_that_cannot_be_made_stops_no_other(done: Done) -> None:
    _, outcomes, folder = done
    assert [outcome.puzzle is None for outcome in outcomes] == [False, False, True]
    assert "mm long, and 30 to 1000 mm can be made: make the object larger" in outcomes[2].reason
    assert len(outcomes[2].attempts) >= 1
    assert outcomes[2].attempts[0].counterpart in NAMES
    assert sorted(path.name for path in folder.iterdir() if path.is_dir()) == [
        f"slice-{outcome.slice.number}-{puzzle.counterpart}" for outcome, puzzle in puzzles(done)
    ]


def test_each_counterpart_is_taken_once(done: Done) -> None:
    taken = [puzzle.counterpart for _, puzzle in puzzles(done)]
    assert len(set(taken)) == len(taken)
    assert set(taken) <= set(NAMES)


def test_every_slice_is_certified_at_its_own_size(done: Done) -> None:
    stack = done[0]
    for outcome, puzzle in puzzles(done):
        assert puzzle.transform.certificate().passed
        assert puzzle.certificate.passed
        assert puzzle.built.design.parameters.height == stack.thickness
        # A unit of the shape is the slice's: area 1 is its area in mm².
        assert puzzle.built.design.scale**2 == pytest.approx(outcome.slice.area, rel=2e-2)
        assert puzzle.built.design.scale == pytest.approx(abs(puzzle.transform.p.to_source[0, 0]), rel=1e-12)


def test_solids_read_back_and_stack_in_place(done: Done) -> None:
    """Placed by what the files say, the pieces of a slice lie in its slab, over its outline."""
    stack, _, folder = done
    document = json.loads((folder / "set.json").read_text(encoding="utf-8"))
    for entry, slice_ in zip(document["slices"], stack.slices, strict=True):
        if "folder" not in entry:
            continue
        where = folder / entry["folder"]
        transform = Transform.load(where / "puzzle.riot")
        parts = json.loads((where / "parts.json").read_text(encoding="utf-8"))
        scale, lies = parts["mm_per_unit"], {part["name"]: part["printed"] for part in parts["parts"]}
        pose = transform.pose(0.0)
        low, high, volume = [], [], 0.0
        for i in range(len(transform)):
            mesh = trimesh.load_mesh(where / f"piece-{i + 1}.stl")
            assert mesh.is_watertight
            volume += mesh.volume
            if lies[f"piece-{i + 1}"] == "upside down":
                mesh.vertices = mesh.vertices * [1.0, -1.0, -1.0] + [0.0, 0.0, mesh.extents[2]]
            flat = scale * pose.place(i, mesh.vertices[:, :2] / scale) + entry["place_mm"]
            low.append([*flat.min(axis=0), mesh.vertices[:, 2].min()])
            high.append([*flat.max(axis=0), mesh.vertices[:, 2].max()])
        assert (min(z for *_, z in low), max(z for *_, z in high)) == (
            0.0,
            pytest.approx(entry["high_mm"] - entry["low_mm"]),
        )
        box = np.array(slice_.outline.bounds)
        box_of_mesh = np.concatenate([np.min(low, axis=0)[:2], np.max(high, axis=0)[:2]])
        assert np.abs(box_of_mesh - box).max() < 0.1 * scale
        assert 0.85 < volume / (slice_.area * stack.thickness) < 1.05
        assert min(entry["iou_slice"], entry["iou_counterpart"]) > 0.85


def test_the_list_says_what_became_of_every_slice(done: Done) -> None:
    stack, outcomes, folder = done
    document = json.loads((folder / "set.json").read_text(encoding="utf-8"))
    assert document == json.loads(json.dumps(set_document(stack, outcomes)))
    assert (document["format"], document["made"], document["along"]) == ("riot-set", 2, "z")
    assert document["height_mm"] == 72.0
    assert [entry["area_mm2"] for entry in document["slices"]] == pytest.approx([s.area for s in stack.slices])
    assert document["slices"][2]["reason"] == outcomes[2].reason


def test_the_pictures_show_every_slice(done: Done) -> None:
    _, outcomes, folder = done
    pixels = np.asarray(Image.open(folder / "overview.png").convert("RGB")).astype(np.int64)
    coloured = np.flatnonzero((np.ptp(pixels, axis=2) > 60).any(axis=0))
    inked = np.flatnonzero((pixels < 250).any(axis=(0, 2)))
    # A grey object on the left, a coloured stack in the middle, coloured turned slices on the right.
    assert coloured[0] > inked[0] + 0.2 * len(inked)
    assert inked[-1] - coloured[-1] < 0.1 * len(inked)
    assert np.diff(coloured).max() > 20
    scene = slices_scene(outcomes)
    words = " ".join(mark.text for mark in scene.marks if hasattr(mark, "text"))
    assert all(
        f"slice {outcome.slice.number}" in words and puzzle.counterpart in words for outcome, puzzle in puzzles(done)
    )


def test_files_are_the_same_bytes_every_time(done: Done, tmp_path: Path) -> None:
    stack, outcomes, folder = done
    written = write_set(stack, outcomes, tmp_path / "again")
    names = [path.relative_to(tmp_path / "again") for path in written]
    assert names == sorted(path.relative_to(folder) for path in folder.rglob("*") if path.is_file())
    for name in names:
        assert (tmp_path / "again" / name).read_bytes() == (folder / name).read_bytes()


def test_nothing_is_written_if_anything_fails(done: Done, tmp_path: Path) -> None:
    stack, outcomes, _ = done

    def broken(puzzle: Puzzle) -> list[object]:
        def write(folder: Path) -> None:
            assert (folder / "parts.json").exists()
            raise RuntimeError("the saw is blunt")

        return [write] if puzzle is puzzles(done)[-1][1] else []

    with pytest.raises(RuntimeError, match="blunt"):
        write_set(stack, outcomes, tmp_path / "set", broken)  # type: ignore[arg-type]
    none = tuple(replace(outcome, puzzle=None, reason="too late") for outcome in outcomes)
    with pytest.raises(ModelError, match="no slice could be made: slice 1: too late"):
        write_set(stack, none, tmp_path / "set")
    assert list(tmp_path.iterdir()) == []


def test_a_stack_of_failures_alone_still_has_a_picture(done: Done, tmp_path: Path) -> None:
    stack, outcomes, _ = done
    draw_overview(stack, [replace(outcome, puzzle=None) for outcome in outcomes], tmp_path / "grey.png")
    pixels = np.asarray(Image.open(tmp_path / "grey.png").convert("RGB")).astype(np.int64)
    assert np.ptp(pixels, axis=2).max() < 20
    assert pixels.min() < 100


def test_a_slice_is_mended_when_told_to() -> None:
    stack = cut(Model("egg", low_egg().scale((2.0, 2.0, 1.0))), Cut(1, 16.0, along="z"))
    thick = FabricationParameters(pin_mm=8.0, wall_mm=0.8)

    def first_outcome(mend: bool) -> SliceOutcome:
        (outcome,) = make_puzzles(stack, lambda slices: shortlists(slices, counterparts()[1:2], 1), thick, mend=mend)
        return outcome

    asked, mended = first_outcome(False), first_outcome(True)
    assert asked.puzzle is None and asked.attempts[0].counterpart == "polygon-square"
    assert mended.puzzle is not None
    assert mended.puzzle.built.changes == ("pin_mm: 1.75 instead of 8", "pivot: rod instead of printed")


def test_a_slice_too_small_for_its_hinges_keeps_its_size_and_says_what_is_enough() -> None:
    stack = cut(Model("egg", low_egg()), Cut(1, 16.0, along="z"))
    coarse = FabricationParameters(pin_mm=1.75, wall_mm=10.0)
    (outcome,) = make_puzzles(stack, lambda slices: shortlists(slices, counterparts()[1:2], 1), coarse, mend=True)
    assert outcome.puzzle is None
    reason = outcome.attempts[0].reason
    assert reason.startswith("it is only ") and "slices keep their size: make the object" in reason
    assert "instead of" not in reason  # nothing was tried that a slice could not have


class TestCommand:
    """`riot slices` itself."""

    @pytest.fixture
    def model(self, tmp_path: Path) -> Path:
        mesh = low_egg().to_mesh64()
        trimesh.Trimesh(mesh.vert_properties[:, :3], mesh.tri_verts.astype(np.int64)).export(tmp_path / "egg.stl")
        return tmp_path / "egg.stl"

    @pytest.fixture
    def pictures(self, tmp_path: Path) -> list[str]:
        for name in NAMES:
            pixels = sample.picture(f"{SAMPLE_PREFIX}{name}").astype(np.uint8)
            Image.fromarray(pixels).save(tmp_path / f"{name}.png")
        return [str(tmp_path / f"{name}.png") for name in NAMES]

    def test_makes_the_set(
        self, model: Path, pictures: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        out = tmp_path / "out"
        given = ["slices", str(model), "--count", "2", "--thickness", "20", "--along", "z", "-o", str(out)]
        assert main([*given, "--into", ",".join(pictures[:2]), "--pin", "1.75"]) == MADE
        output = capsys.readouterr()
        assert "2 slices of 20 mm along z" in output.out
        assert str(out) in output.out
        document = json.loads((out / "set.json").read_text(encoding="utf-8"))
        assert document["model"] == "egg"
        assert all(entry["certified"] and entry["counterpart"] in NAMES[:2] for entry in document["slices"])
        parts = json.loads((out / document["slices"][0]["folder"] / "parts.json").read_text(encoding="utf-8"))
        assert (parts["parameters"]["pin_mm"], parts["parameters"]["thickness_mm"]) == (1.75, 20.0)
        assert main([*given, "--into", *pictures]) == BAD
        assert "is there already" in capsys.readouterr().err

    def test_tells_other_programs_the_same(
        self, model: Path, pictures: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        out = tmp_path / "out"
        given = ["slices", str(model), "--count", "1", "--thickness", "20", "--along", "z", "-o", str(out), "--json"]
        assert main([*given, "--into", pictures[0], "--pin", "1.75"]) == MADE
        document = json.loads(capsys.readouterr().out)
        assert document["folder"] == str(out)
        assert document["set"] == json.loads((out / "set.json").read_text(encoding="utf-8"))

    @pytest.mark.parametrize(
        ("options", "message"),
        [
            (["--count", "2", "--thickness", "3"], "--thickness: must be 6 to 30 mm, got 3.0"),
            (["--count", "0"], "count is 0: give a number above 0"),
            (["--count", "2", "--thickness", "20", "--size", "90"], "leave one of count, thickness and size out"),
            (["--count", "2", "--thickness", "20", "--pin", "99"], "--pin: must be 1.75 to 8 mm, got 99.0"),
            (["--count", "2", "--thickness", "20", "--candidates", "0"], "--candidates 0: try one at least"),
        ],
    )
    def test_says_what_is_wrong(
        self,
        options: list[str],
        message: str,
        model: Path,
        pictures: list[str],
        tmp_path: Path,
        capsys: pytest.CaptureFixture[str],
    ) -> None:
        out = tmp_path / "out"
        assert main(["slices", str(model), "--into", pictures[0], "-o", str(out), *options]) == BAD
        assert message in capsys.readouterr().err
        assert not out.exists()

    def test_says_what_is_wrong_with_the_counterparts(
        self, model: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        given = ["slices", str(model), "--count", "2", "--thickness", "20", "-o", str(tmp_path / "out")]
        assert main(given) == BAD
        assert "give pictures with --into" in capsys.readouterr().err
        assert main([*given, "--into", str(tmp_path / "absent.png")]) == BAD
        assert "absent.png" in capsys.readouterr().err
        ring = np.hypot(*(np.mgrid[:200, :200] - 100.0))
        Image.fromarray(((abs(ring - 90.0) < 4.0) & (np.mgrid[:200, :200][0] > 40) * 255).astype(np.uint8)).save(
            tmp_path / "arc.png"
        )
        assert main([*given, "--into", str(tmp_path / "arc.png")]) == BAD
        assert "no counterpart has a trunk (arc)" in capsys.readouterr().err
        assert not (tmp_path / "out").exists()

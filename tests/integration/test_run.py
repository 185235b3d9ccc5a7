"""The real pipeline: tables, resuming, sameness on every cluster, bad input, sweeps, exit codes.

In processes of its own where that matters, else in this one, which saves the start.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
from collections import Counter
from pathlib import Path

import duckdb
import geopandas
import numpy as np
import psutil
import pyarrow.parquet as pq
import pytest
import shapely
from PIL import Image, ImageDraw
from small_runs import (
    BAD_START,
    CLEAN,
    INTERRUPTED,
    SHAPES,
    WITH_ERRORS,
    command,
    digests,
    draw,
    pictures,
    run,
    run_here,
    stages,
    table,
)

from pipeline.run import main
from pipeline.store.store import PAYLOAD
from pipeline.tables.schemas import SCHEMAS
from riot import Transform


def test_tables_are_whole_and_documented(finished: Path) -> None:
    folder = finished / "outputs" / "folder"
    for name, schema in SCHEMAS.items():
        path = folder / name / "part-0000.parquet" if name == "qcrs" else folder / f"{name}.parquet"
        assert pq.read_schema(path).equals(schema, check_metadata=True)
        assert all(field.metadata[b"meaning"] for field in schema)
    shapes = table(finished, "shapes")
    assert [row["shape"] for row in shapes] == list(range(SHAPES))
    assert [row["name"] for row in shapes] == sorted(row["name"] for row in shapes)  # type: ignore[type-var]
    assert {row["class"] for row in shapes} == {"kind0", "kind1", "kind2", "kind3"}
    qcrs = pq.read_table(folder / "qcrs").to_pandas()
    assert len(qcrs) == SHAPES * (SHAPES - 1) // 2 and (qcrs["i"] < qcrs["j"]).all()
    assert qcrs["score"].between(0, 1).all() and not qcrs.duplicated(["i", "j"]).any()
    assert qcrs[["i", "j"]].apply(tuple, axis=1).is_monotonic_increasing
    trunks = pq.read_table(folder / "trunks.parquet").to_pandas()
    counts = trunks.groupby("shape").size()
    assert all(row["trunks"] == counts.get(row["shape"], 0) for row in shapes)
    for row in qcrs[qcrs["score"] > 0].itertuples():
        assert row.trunk_i < counts[row.i] and row.trunk_j < counts[row.j]
    assert len(table(finished, "reversibility")) == SHAPES
    assert table(finished, "errors") == []


def test_outlines_are_read_by_geopandas_and_duckdb_as_they_are(finished: Path) -> None:
    folder = finished / "outputs" / "folder"
    shapes, transforms = (geopandas.read_parquet(folder / f"{name}.parquet") for name in ("shapes", "transforms"))
    assert shapes.crs is None and shapes.geometry.name == "outline" and transforms.geometry.name == "outline_p"
    assert shapes.area.to_numpy() == pytest.approx(1.0) and shapes.length.to_numpy() == pytest.approx(shapes.perimeter)
    assert all(outline.is_simple and outline.exterior.is_ccw for outline in shapes.geometry)
    assert (shapes.geometry.count_coordinates() == shapes.points + 1).all()
    constructed = transforms[transforms.file != ""]
    assert len(constructed) and transforms[transforms.file == ""].outline_q.isna().all()
    for row in constructed.itertuples():
        transform = Transform.load(folder / row.file)
        assert np.array_equal(np.array(row.outline_p.exterior.coords)[:-1], transform.outline_p())
        assert np.array_equal(np.array(row.outline_q.exterior.coords)[:-1], transform.outline_q())
    plain = duckdb.sql(f"SELECT outline::BLOB FROM '{folder}/shapes.parquet' ORDER BY shape").fetchall()
    assert [shapely.from_wkb(wkb) for (wkb,) in plain] == list(shapes.geometry)


def test_selected_pairs_are_the_best_and_become_transforms(finished: Path) -> None:
    selected = table(finished, "selected")
    assert [row["rank"] for row in selected] == [1, 2, 3, 4, 5, 6]
    assert all(row["class_i"] != row["class_j"] for row in selected)
    assert [row["qcrs"] for row in selected] == sorted((row["qcrs"] for row in selected), reverse=True)  # type: ignore[type-var]
    assert {(row["i"], row["j"]) for row in table(finished, "crs")} == {(row["i"], row["j"]) for row in selected}
    transforms = table(finished, "transforms")
    assert len(transforms) == 3
    # Constructed are the pairs whose trunks allow the least deformation; no shape stands in more than two.
    bounds = {(row["i"], row["j"]): row["bound"] for row in table(finished, "crs")}
    constructed = {(row["i"], row["j"]) for row in transforms}
    times = Counter(number for pair in constructed for number in pair)
    least = min(bounds[pair] for pair in constructed)
    for pair in bounds.keys() - constructed:
        assert bounds[pair] <= least or max(times[number] for number in pair) == 2
    certified = [row for row in transforms if row["status"] == "certified"]
    assert all(row["change_ratio"] > 0.99 and row["paper_iou"] is None for row in certified)  # type: ignore[operator]
    assert all(row["bending_p"] > 0.0 and 0.0 < row["direction_q"] < 0.5 for row in certified)  # type: ignore[operator]
    assert [row["iou"] for row in certified] == sorted((row["iou"] for row in certified), reverse=True)  # type: ignore[type-var]
    for row in certified:
        transform = Transform.load(finished / "outputs" / "folder" / str(row["file"]))
        assert transform.certificate().passed and len(transform) == row["n"]
        assert (transform.p.name, transform.q.name) == (row["name_i"], row["name_j"])
    assert all(row["reason"] and row["file"] == "" for row in transforms if row["status"] == "rejected")


def test_two_workers_write_the_same_bytes(finished: Path, root: Path, tmp_path: Path) -> None:
    done = run(tmp_path, root, "cluster=local", "cluster.workers=2")
    assert done.returncode == CLEAN, done.stdout + done.stderr
    assert digests(tmp_path) == digests(finished)


def test_a_finished_run_computes_nothing_and_says_so(copied: Path, root: Path) -> None:
    folder = copied / "outputs" / "folder"
    before = {file: file.stat().st_mtime_ns for file in folder.rglob("*")}
    done = run_here(copied, root, "cluster=sync")
    assert done.returncode == CLEAN and "Everything cached: nothing was computed" in done.stdout
    assert {file: file.stat().st_mtime_ns for file in folder.rglob("*")} == before
    plan = run_here(copied, root, "--plan")
    assert plan.returncode == CLEAN and "nothing was run" in plan.stdout
    facts = json.loads(run_here(copied, root, "cluster=sync", "--json").stdout)
    assert (facts["format"], facts["version"], facts["exit_code"]) == ("riot-mine", 1, CLEAN)
    assert [(stage["computed"], stage["cached"]) for stage in facts["stages"]] == [
        (0, stage["items"]) for stage in facts["stages"]
    ]
    assert {stage["stage"] for stage in facts["stages"]} == set(stages(copied))
    assert Path(facts["report"]).is_file()


def test_lost_tables_are_written_again_from_the_store(copied: Path, finished: Path, root: Path) -> None:
    (copied / "outputs" / "folder" / "crs.parquet").unlink()
    done = run_here(copied, root, "cluster=sync")
    assert done.returncode == CLEAN and "nothing was computed" in done.stdout
    assert digests(copied) == digests(finished)
    assert all(stage["computed"] == 0 for stage in stages(copied).values())


def test_a_place_changes_nothing(finished: Path, root: Path, tmp_path: Path) -> None:
    """The same pictures elsewhere: everything is found in the store, and the tables are the same to the byte."""
    moved = Path(shutil.copytree(root, tmp_path / "moved pictures"))
    shutil.copytree(finished / "store", tmp_path / "store")
    done = run_here(tmp_path, moved, "cluster=sync")
    assert done.returncode == CLEAN and "nothing was computed" in done.stdout
    assert digests(tmp_path) == digests(finished)


def test_one_more_picture_costs_its_own_batch_and_blocks(copied: Path, root: Path, tmp_path: Path) -> None:
    grown = Path(shutil.copytree(root, tmp_path / "grown"))
    draw(grown / "kind9-99.png", 99)
    done = run_here(copied, grown, "cluster=sync")
    assert done.returncode == CLEAN
    counts = stages(copied)
    assert counts["ingest"]["computed"] <= 2 and counts["ingest"]["cached"] >= 1
    assert counts["qcrs"]["cached"] >= 1
    assert len(table(copied, "shapes")) == SHAPES + 1


def test_a_parameter_redoes_what_reads_it_and_explains(copied: Path, root: Path) -> None:
    explained = run_here(copied, root, "crs.sigma_area=0.25", "compare=1", "--explain")
    assert explained.returncode == CLEAN
    assert "crs: 6 of 6 to do" in explained.stdout and "parameters.crs.sigma_area 0.3 → 0.25" in explained.stdout
    assert "qcrs: all" in explained.stdout and "paper: known after construct" in explained.stdout
    done = run_here(copied, root, "crs.sigma_area=0.25", "compare=1", "cluster=sync")
    assert done.returncode == CLEAN, done.stdout + done.stderr
    counts = stages(copied)
    assert counts["qcrs"]["computed"] == 0 and counts["trunks_full"]["computed"] == 0 and counts["crs"]["computed"] == 6
    # The best one was made by the paper's method too.
    best, *others = table(copied, "transforms")
    assert counts["paper"]["computed"] == 1 and 0.5 < best["paper_iou"] < 1.0  # type: ignore[operator]
    assert all(row["paper_iou"] is None for row in others)
    assert "Beside the paper's method" in done.stdout
    assert '<section id="beside">' in (copied / "outputs" / "folder" / "report.html").read_text()


def test_the_best_transforms_become_puzzles(copied: Path, root: Path) -> None:
    folder, wanted = copied / "outputs" / "folder", ("fabricate.top=1", "fabricate.size_mm=200", "fabricate.fix=true")
    explained = run_here(copied, root, *wanted, "--explain")
    assert explained.returncode == CLEAN and "fabricate: 1 of 1 to do" in explained.stdout
    done = run_here(copied, root, *wanted, "cluster=sync")
    assert done.returncode == CLEAN, done.stdout + done.stderr
    counts = stages(copied)
    assert counts["motion"]["computed"] == 0 and counts["fabricate"]["computed"] == 1
    best, (row,) = table(copied, "transforms")[0], table(copied, "fabrications")
    assert (row["rank"], row["i"], row["j"]) == (1, best["i"], best["j"])
    assert row["status"] == "certified", row["message"]
    assert row["folder"] == f"print/{Path(str(best['file'])).stem}"
    printed = {path.name for path in (folder / str(row["folder"])).iterdir()}
    assert {"piece-1.stl", "plate-1.3mf", "parts.json"} <= printed
    assert '<section id="puzzles">' in (folder / "report.html").read_text()
    # Without puzzles the run is as it was before, and none of theirs is left.
    assert run_here(copied, root, "cluster=sync").returncode == CLEAN
    assert not list((folder / "print").iterdir()) and table(copied, "fabrications") == []


def test_a_damaged_artifact_is_made_again(copied: Path, finished: Path, root: Path) -> None:
    payload = next(iter(sorted((copied / "store" / "trunks").rglob(PAYLOAD))))
    raw = bytearray(payload.read_bytes())
    raw[-1] ^= 255
    payload.write_bytes(raw)
    done = run_here(copied, root, "cluster=sync")
    assert done.returncode == CLEAN and "trunks: 1 damaged" in done.stdout and "corrupt" in done.stdout
    assert re.search(r"^trunks +10 shapes, \d of them in the store in", done.stdout, re.MULTILINE)
    assert payload.read_bytes() != bytes(raw) and digests(copied) == digests(finished)


@pytest.mark.parametrize("after", ["ingest", pytest.param("qcrs", marks=pytest.mark.system)])
def test_a_killed_run_goes_on_where_it_was(after: str, finished: Path, root: Path, tmp_path: Path) -> None:
    with subprocess.Popen(
        command(tmp_path, root, "cluster=local", "cluster.workers=1"), stdout=subprocess.PIPE, text=True, cwd=tmp_path
    ) as process:
        assert process.stdout is not None
        for line in process.stdout:
            if line.startswith(after) and (" shapes in " in line or " pairs in " in line):
                break
        process.kill()
    assert not (tmp_path / "outputs" / "folder" / "run.json").exists()
    done = run_here(tmp_path, root, "cluster=sync")
    assert done.returncode == CLEAN, done.stdout + done.stderr
    assert stages(tmp_path)[after]["computed"] == 0
    assert digests(tmp_path) == digests(finished)


@pytest.mark.system
@pytest.mark.skipif(os.name != "posix", reason="process groups are POSIX")
def test_an_interrupt_says_how_to_go_on(root: Path, tmp_path: Path) -> None:
    with subprocess.Popen(
        command(tmp_path, root, "cluster=local", "cluster.workers=2"),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=tmp_path,
        start_new_session=True,
        # Where the tests run in the background, interrupts are ignored, and processes inherit that.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    ) as process:
        assert process.stdout is not None
        for line in process.stdout:
            if line.startswith("ingest") and " shapes in " in line:
                break
        os.killpg(process.pid, signal.SIGINT)  # as a terminal does: to the workers too
        _, complaint = process.communicate(timeout=120)
    assert process.returncode == INTERRUPTED
    assert "the same command goes on" in complaint and "Traceback" not in complaint


@pytest.mark.system
@pytest.mark.skipif(os.name != "posix", reason="process groups are POSIX")
@pytest.mark.parametrize("end", [signal.SIGINT, signal.SIGKILL])
def test_what_ends_a_run_ends_the_compilation_of_kernels(root: Path, tmp_path: Path, end: signal.Signals) -> None:
    with subprocess.Popen(
        command(tmp_path, root, "cluster=sync"),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=tmp_path,
        env={**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "kernels"), "PYTHONUNBUFFERED": "1"},
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    ) as process:
        assert process.stdout is not None
        lines = iter(process.stdout)
        assert any(line.startswith("compiling 1") for line in lines)  # more than nine modules
        assert any(line.startswith(("kernels", "ingest")) for line in lines)  # the first stage waits for its kernels
        compilers = psutil.Process(process.pid).children(recursive=True)
        assert compilers
        process.send_signal(end)
        process.communicate(timeout=20)
    assert process.returncode == (INTERRUPTED if end is signal.SIGINT else -end)
    _, alive = psutil.wait_procs(compilers, timeout=20)
    assert alive == []


def test_bad_pictures_are_rows_and_the_run_goes_on(root: Path, tmp_path: Path) -> None:
    folder = Path(shutil.copytree(root, tmp_path / "pictures"))
    (folder / "text-1.png").write_text("this is no picture")
    whole = (folder / "kind0-0.png").read_bytes()
    (folder / "cut-1.png").write_bytes(whole[: len(whole) // 2])
    Image.new("L", (40, 40), 255).save(folder / "plain-1.png")
    Image.new("L", (1, 1), 0).save(folder / "dot-1.png")
    (folder / "twin-1.png").write_bytes(whole)
    draw(folder / "mit Leerzeichen é-1.png", 55)
    (folder / "notes.txt").write_text("no item")
    (folder / "blank-1.png").touch()
    Image.fromarray(np.array([[0, 255, 255, 0]] * 2, dtype=np.uint8)).save(folder / "border-1.png")
    (folder / "gone-1.png").symlink_to(folder / "nothing.png")
    done = run_here(tmp_path, folder, "cluster=sync")
    assert done.returncode == WITH_ERRORS, done.stdout + done.stderr
    errors = {row["item"]: row for row in table(tmp_path, "errors")}
    reasons = {"text-1": "not-a-picture", "cut-1": "unreadable", "plain-1": "one-colour", "dot-1": "one-colour"}
    reasons |= {"twin-1": "duplicate", "blank-1": "not-a-picture", "border-1": "all-border", "gone-1": "unreadable"}
    assert {name: row["reason"] for name, row in errors.items()} == reasons
    assert all(row["message"] and row["attempts"] == 1 for row in errors.values())
    assert "Finished with 7 errors" in done.stdout and "1 file is left out" in done.stdout
    assert "1 file was ignored" in done.stdout
    assert not any(str(tmp_path) in str(row["message"]) for row in errors.values())
    names = {row["name"]: row["source"] for row in table(tmp_path, "shapes")}
    assert len(names) == SHAPES + 1 and names["mit Leerzeichen é-1"] == "mit Leerzeichen é-1.png"
    qcrs = pq.read_table(tmp_path / "outputs" / "folder" / "qcrs")
    assert len(qcrs) == (SHAPES + 1) * SHAPES // 2
    again = run_here(tmp_path, folder, "cluster=sync")
    assert again.returncode == WITH_ERRORS and "nothing was computed" in again.stdout


def test_odd_shapes_are_shapes_and_those_without_trunks_are_counted(root: Path, tmp_path: Path) -> None:
    folder = pictures(tmp_path / "pictures", range(2))
    needle = np.zeros((40, 1000), dtype=np.uint8)
    needle[19:21, 20:980] = 255
    Image.fromarray(needle).save(folder / "needle-1.png")
    blobs = Image.new("L", (120, 80))
    for box in ((5, 5, 50, 50), (60, 20, 110, 70)):
        ImageDraw.Draw(blobs).ellipse(box, fill=255)
    blobs.save(folder / "blobs-1.png")
    turn = np.linspace(0.0, 6 * np.pi, 2000)
    reach = 10 + 8 * turn
    spiral = Image.new("L", (400, 400))
    ImageDraw.Draw(spiral).line(
        [(200 + x, 200 + y) for x, y in zip(reach * np.cos(turn), reach * np.sin(turn), strict=True)], 255, width=12
    )
    spiral.save(folder / "spiral-1.png")
    done = run_here(tmp_path, folder, "cluster=sync")
    assert done.returncode == CLEAN, done.stdout + done.stderr
    trunks = {str(row["name"]): row["trunks"] for row in table(tmp_path, "shapes")}
    assert trunks.keys() == {"blobs-1", "kind0-0", "kind1-1", "needle-1", "spiral-1"}
    without = [name for name, count in trunks.items() if count == 0]
    assert "needle-1" in without and "kind0-0" not in without
    sentence = f"{len(without)} shape" + (" has" if len(without) == 1 else "s have") + " no trunk"
    assert sentence in done.stdout and sentence in (tmp_path / "outputs" / "folder" / "report.html").read_text()
    qcrs = pq.read_table(tmp_path / "outputs" / "folder" / "qcrs").to_pylist()
    needle_number = sorted(trunks).index("needle-1")
    lonely = [row for row in qcrs if needle_number in (row["i"], row["j"])]
    assert len(lonely) == len(trunks) - 1 and all(row["score"] == 0 and row["n"] == 0 for row in lonely)


def test_shapes_of_one_class_make_no_pair_and_that_is_said(tmp_path: Path) -> None:
    folder = tmp_path / "pictures" / "all"
    folder.mkdir(parents=True)
    for number in range(3):
        draw(folder / f"{number}.png", number)
    for policy in ("global", "paper"):
        done = run_here(tmp_path, folder.parent, "cluster=sync", f"select.policy={policy}")
        assert done.returncode == CLEAN, done.stdout + done.stderr
        assert f"No pair was selected: select.policy={policy}" in done.stdout
    assert table(tmp_path, "transforms") == []


def test_a_collection_without_one_shape_still_ends_well(tmp_path: Path) -> None:
    folder = tmp_path / "pictures"
    folder.mkdir()
    (folder / "text-1.png").write_text("this is no picture")
    done = run_here(tmp_path, folder, "cluster=sync")
    assert done.returncode == WITH_ERRORS, done.stdout + done.stderr
    assert table(tmp_path, "shapes") == [] and len(table(tmp_path, "errors")) == 1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["+dataset=folder", "dataset.root={empty}"], ["no pictures", "dataset.root"]),
        (["+dataset=folder", "dataset.root={empty}/none"], ["does not exist"]),
        (["+dataset=mpeg7", "dataset.root={empty}/none"], ["pipeline.fetch mpeg7"]),
        (["trunks.tau=1"], ["trunks.tau_s", "Allowed"]),
        (["trunks.tau_s=x"], ["number"]),
        (["outputs={file}"], ["cannot write", "outputs=DIR"]),
        (["outputs={file}/deeper"], ["cannot write", "outputs=DIR"]),
        (["store={file}"], ["cannot write", "store=DIR"]),
        (["outputs={file}/deeper", "-m", "select.top=1,2"], ["cannot write", "outputs=DIR"]),
        (["-m", "select.top=1,x"], ["select.top", "whole number"]),
        (["dataset.root={empty}"], ["+dataset=folder"]),
    ],
)
def test_what_cannot_start_says_why_and_does_nothing(
    arguments: list[str],
    words: list[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    empty, file, where = tmp_path / "empty", tmp_path / "file", tmp_path / "where"
    empty.mkdir()
    file.touch()
    where.mkdir()
    monkeypatch.chdir(where)
    assert main([argument.format(empty=empty, file=file) for argument in arguments]) == BAD_START
    complaint = capsys.readouterr().err
    assert all(word in complaint for word in words) and "Traceback" not in complaint
    assert not (where / "store").exists() or not list((where / "store").rglob("*.bin"))


def test_the_environment_changes_no_result(finished: Path, root: Path, tmp_path: Path) -> None:
    where = tmp_path / "env"
    where.mkdir()
    environment = {**os.environ, "OMP_NUM_THREADS": "3", "NUMBA_NUM_THREADS": "2", "PYTHONHASHSEED": "7", "LC_ALL": "C"}
    done = subprocess.run(
        command(where, root, "cluster=sync"), capture_output=True, text=True, cwd=where, env=environment, timeout=240
    )
    assert done.returncode == CLEAN, done.stdout + done.stderr
    assert digests(where) == digests(finished)
    # It ran in that folder, and wrote nothing else there.
    assert sorted(path.name for path in where.iterdir()) == ["outputs", "store"]
    assert not list(where.rglob(".tmp-*")) and not list(where.rglob(".probe*"))


def test_the_report_leads_to_every_outline_on_its_picture(finished: Path) -> None:
    folder = finished / "outputs" / "folder"
    report = (folder / "report.html").read_text(encoding="utf-8")
    assert report.index('href="check.html"') < report.index('href="gallery/index.html"')
    sheet = (folder / "check.html").read_text(encoding="utf-8")
    assert all(f"outline of {row['name']}" in sheet for row in table(finished, "shapes"))
    assert "check.html" in json.loads((folder / "run.json").read_text(encoding="utf-8"))["files"]


def test_identical_files_alone_are_no_error(copied: Path, root: Path, tmp_path: Path) -> None:
    folder = tmp_path / "with a copy"
    shutil.copytree(root, folder)
    first = min(folder.glob("*.png"))
    shutil.copy(first, folder / f"{first.stem}~copy.png")
    done = run_here(copied, folder, "cluster=sync")
    assert done.returncode == CLEAN, done.stdout + done.stderr
    assert "1 file is left out: the same bytes as another" in done.stdout

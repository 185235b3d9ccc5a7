"""The real pipeline: tables, transforms, puzzles, sameness on every cluster, at any place and in any environment.

In processes of its own where that matters, else in this one, which saves the start.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from collections import Counter
from pathlib import Path

import duckdb
import geopandas
import numpy as np
import pyarrow.parquet as pq
import pytest
import shapely
from small_runs import (
    CLEAN,
    SHAPES,
    command,
    digests,
    run,
    run_here,
    stages,
    table,
)

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


def test_a_place_changes_nothing(finished: Path, root: Path, tmp_path: Path) -> None:
    """The same pictures elsewhere: everything is found in the store, and the tables are the same to the byte."""
    moved = Path(shutil.copytree(root, tmp_path / "moved pictures"))
    shutil.copytree(finished / "store", tmp_path / "store")
    done = run_here(tmp_path, moved, "cluster=sync")
    assert done.returncode == CLEAN and "nothing was computed" in done.stdout
    assert digests(tmp_path) == digests(finished)


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

"""Studies of a small finished run: files, values that can be checked against the tables, and refusals."""

from __future__ import annotations

import json
from itertools import count
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from html_page import Page
from small_runs import CLEAN, pictures, run_here

from pipeline.study import consistency
from pipeline.study.__main__ import main
from pipeline.study.contents import write_contents
from pipeline.study.finished import StudiedRun
from pipeline.study.registry import STUDIES
from pipeline.study.statistics import agreement
from riot.types import FloatArray, IntArray


@pytest.fixture(scope="module")
def where(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("studied")
    done = run_here(folder, pictures(folder / "pictures"), "cluster=sync")
    assert done.returncode == CLEAN, done.stdout + done.stderr
    return folder


def study(where: Path, name: str, *more: str) -> tuple[int, Path]:
    outputs = where / "outputs"
    data = ("+dataset=folder", f"dataset.root={where / 'pictures'}", f"outputs={outputs}")
    return main([name, *data, *more]), outputs / "folder" / "study" / name


def table(folder: Path) -> list[dict[str, object]]:
    return pq.read_table(folder / "table.parquet").to_pylist()


QUICK = {
    "consistency": ("pairs=20", "bounds=3", "draws=50"),
    "distributions": ("samples=4",),
    "groundtruth": ("pairs=1", "keep=3", "few=1"),
    "parameters": ("pairs=1", "shapes=2", "spacing=[12]", "tau_s=[]", "tau_c=[0.2]", "sigma_pa=[2]", "sigma_w=[]"),
    "quiz": ("pairs=2", "margin=0"),
    "recognition": (),
    "sigmas": ("sigma_area=[0.2]", "pairs=20", "draws=50", "shapes=4", "repeats=1"),
    "timing": (),
    "variety": (),
}


@pytest.fixture(scope="module")
def studied(where: Path) -> dict[str, Path]:
    """The folder of every study, each made once."""
    pages = {name: study(where, name, *more) for name, more in QUICK.items()}
    assert [code for code, _ in pages.values()] == [CLEAN] * len(STUDIES)
    return {name: folder for name, (_, folder) in pages.items()}


@pytest.mark.parametrize("name", sorted(STUDIES))
def test_every_study_writes_a_table_with_units_figures_and_a_page(studied: dict[str, Path], name: str) -> None:
    folder = studied[name]
    schema = pq.read_schema(folder / "table.parquet")
    assert schema.metadata[b"meaning"]
    assert all(field.metadata[b"meaning"] and b"unit" in field.metadata for field in schema)
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert page.count("<figure") == len(list(folder.glob("*.svg"))) > 0
    assert {path.stem for path in folder.glob("*.svg")} == {path.stem for path in folder.glob("*.png")}
    assert "http://" not in page.replace("http://www.w3.org", "") and "<script" not in page


def test_the_page_of_studies_tells_what_each_found_or_how_to_make_it(where: Path, studied: dict[str, Path]) -> None:
    index = studied["timing"].parent / "index.html"
    text = index.read_text(encoding="utf-8")
    page = Page(text)
    links = [link["href"] for link in page.all("a")]
    assert links == ["../report.html", *(f"{name}/report.html" for name in STUDIES)]
    assert all((index.parent / link).is_file() for link in links)
    assert "ordered as by CRS in" in text and "python -m" not in text
    (studied["timing"] / "table.parquet").rename(studied["timing"] / "kept")
    write_contents(index.parents[1])
    assert "python -m pipeline.study timing" in index.read_text(encoding="utf-8")
    (studied["timing"] / "kept").rename(studied["timing"] / "table.parquet")
    write_contents(index.parents[1])
    assert index.read_text(encoding="utf-8") == text


def test_the_same_study_gives_the_same_bytes(where: Path, studied: dict[str, Path]) -> None:
    before = {path.name: path.read_bytes() for path in studied["timing"].iterdir()}
    study(where, "timing")
    assert {path.name: path.read_bytes() for path in studied["timing"].iterdir()} == before


def test_prices_change_no_byte_of_the_table(
    where: Path, studied: dict[str, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    before = (studied["sigmas"] / "table.parquet").read_bytes()
    ticks = count(1)
    monkeypatch.setattr("time.process_time", lambda: float(next(ticks)) ** 3)
    code, folder = study(where, "sigmas", *QUICK["sigmas"])
    assert code == CLEAN and (folder / "table.parquet").read_bytes() == before


def test_consistency_takes_qcrs_of_the_run_from_its_tables(where: Path, studied: dict[str, Path]) -> None:
    scored = pq.read_table(where / "outputs" / "folder" / "qcrs").to_pylist()
    quick = {(row["i"], row["j"]): row["score"] for row in scored}
    rows = table(studied["consistency"])
    assert {row["sample"] for row in rows} == {"uniform", "classes", "selected"}
    assert sum(row["sample"] == "uniform" for row in rows) == 20
    for row in rows:
        assert row["qcrs_paper"] == quick[row["i"], row["j"]]
        assert 0.0 <= row["crs"] <= 1.0 and 0.0 <= row["qcrs_tuned"] <= 1.0  # type: ignore[operator]
    assert sum(np.isfinite(row["bound"]) for row in rows if row["sample"] == "uniform") == 3  # type: ignore[call-overload]
    known = {
        (row["i"], row["j"]): row["score"] for row in pq.read_table(where / "outputs/folder/crs.parquet").to_pylist()
    }
    selected = {(row["i"], row["j"]): row["crs"] for row in rows if row["sample"] == "selected"}
    assert selected.items() == known.items()
    shared = [row for row in rows if (row["i"], row["j"]) in known]
    assert shared and all(row["crs"] == pytest.approx(known[row["i"], row["j"]]) for row in shared)


def test_consistency_leaves_out_pairs_that_the_run_set_aside(where: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    known = StudiedRun.quick_scores

    def one_lost(self: StudiedRun, pairs: IntArray) -> FloatArray:
        scores = known(self, pairs)
        scores[0] = np.nan
        return scores

    monkeypatch.setattr(StudiedRun, "quick_scores", one_lost)
    finished = StudiedRun.open(where / "outputs" / "folder")
    findings = consistency.study(finished, consistency.Parameters(pairs=20, bounds=0, draws=50), lambda text: None)
    assert findings.table.column("sample").to_pylist().count("uniform") == 19
    assert np.isfinite(findings.table.column("qcrs_paper").to_numpy()).all()


def test_sigmas_judge_the_own_of_each_variant_as_consistency_does(studied: dict[str, Path]) -> None:
    pairs = [row for row in table(studied["consistency"]) if row["sample"] == "uniform"]
    cross = np.array([row["crs"] for row in pairs], dtype=np.float64)
    rows = table(studied["sigmas"])
    assert [row["sigma_area"] for row in rows if row["variant"] == "paper"] == [0.1, 0.2]
    for row in rows:
        if row["own"]:
            quick = np.array([pair[f"qcrs_{row['variant']}"] for pair in pairs], dtype=np.float64)
            known = agreement(quick, cross, 50, 2018)
            assert (row["alike"], row["share"], row["halved"]) == (known.alike, known.share, known.halved)
    assert (
        np.array([row["price"] for row in pq.read_table(studied["sigmas"] / "times.parquet").to_pylist()]) > 0.0
    ).all()


def test_distributions_count_every_shape_and_pair(studied: dict[str, Path]) -> None:
    rows = {(row["score"], row["class"]): row for row in table(studied["distributions"])}
    assert (rows["S_r", ""]["values"], rows["QCRS", ""]["values"]) == (10, 45)
    assert sum(row["values"] for (score, cls), row in rows.items() if score == "S_r" and cls) == 10  # type: ignore[misc]


def test_timing_is_that_of_the_runs_artifacts(where: Path, studied: dict[str, Path]) -> None:
    rows = {row["step"]: row for row in table(studied["timing"])}
    timings = {row["stage"]: row for row in pq.read_table(where / "outputs/folder/timings.parquet").to_pylist()}
    assert rows["QCRS"]["ours"] == pytest.approx(timings["qcrs"]["stored_seconds"] / 45)
    assert rows["QCRS"]["ratio"] == pytest.approx(1.99 / rows["QCRS"]["ours"])  # type: ignore[operator]


def test_hidden_pairs_are_ranked_by_both_variants(studied: dict[str, Path]) -> None:
    rows = table(studied["groundtruth"])
    assert [row["name"] for row in rows] == ["hidden000-p", "hidden000-q"]
    for row in rows:
        assert row["rank_paper"] == row["quick_rank"]
        assert 1 <= row["rank_tuned"] <= 11  # type: ignore[operator]
        assert row["iou_polygons"] > 0.99  # type: ignore[operator]


def test_mistakes_are_told(where: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for arguments, words in (
        ([], "name a study"),
        (["consistence"], "no such study"),
        (["consistency", "pairs=2"], "pairs: must be 3 or more"),
        (["consistency", "pairs=many"], "pairs: expected a whole number"),
        (["consistency", "pair=3"], "no such parameter"),
        (["timing", f"outputs={tmp_path}"], "no finished run here"),
    ):
        assert main(arguments) == 2
        assert words in capsys.readouterr().err
    with (where / "outputs" / "folder" / "run.json").open(encoding="utf-8") as stream:
        assert json.load(stream)  # studies leave the run's record alone

"""The benchmarks of recovery and of intricate shapes run, and what they report is consistent; no times."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from small_runs import pictures

FOLDER = Path(__file__).parents[2] / "benchmarks"

PARTS = """
import json, sys
sys.path.insert(0, sys.argv[1])
from dataclasses import replace
import numpy as np
from pipeline.study.hidden import failed_test, hide
from pipeline.study.partners import changed
from pipeline.study.statistics import wilson
from riot import groundtruth
from riot.parameters import TrunkParameters
from riot.geometry.polyline import edge_lengths, signed_area
from riot.scores.trunks import full_trunks, quick_trunks

told = {"wilson": wilson(9, 10), "all": wilson(20, 20), "none": wilson(0, 20)}
(first, second), left_out = hide(2, [3, 4])
told["off"], told["areas"], told["near"], told["edges"] = [], [], [], []
for pair in (first, second):
    for side in (pair.p, pair.q):
        outline = side.shape.points
        along = np.concatenate([np.linspace(a, b, 9) for a, b in zip(outline, np.roll(outline, -1, axis=0))])
        gap = np.hypot(*np.moveaxis(side.corners[:, None] - along[None], 2, 0)).min(axis=1)
        told["off"].append(gap.max())
        told["areas"].append(signed_area(side.corners))
        told["near"] += [
            failed_test(side, quick_trunks(side.shape), True, TrunkParameters()),
            failed_test(side, full_trunks(side.shape), False, TrunkParameters()),
        ]
    edges = edge_lengths(pair.p.corners), edge_lengths(pair.q.corners)[::-1]
    told["edges"].append(min(np.abs(edges[0] - np.roll(edges[1], k)).max() for k in range(pair.n)))
side = second.p
none = replace(TrunkParameters(), min_area=0.9)
told["area"] = failed_test(side, quick_trunks(side.shape, none), True, none)
none = replace(TrunkParameters(), tau_c=1.0)
told["congruency"] = failed_test(side, full_trunks(side.shape, none), False, none)
none = replace(TrunkParameters(), tau_s=1.0)
told["convex"] = failed_test(side, quick_trunks(side.shape, none), True, none)
trunks, refinement = changed(["trunks.tau_s=0.07", "refine.candidates=64"])
told["changed"] = [trunks.tau_s, trunks.spacing, refinement.candidates, refinement.refined]
limits = {name: value for name, value in vars(groundtruth).items() if name.isupper()}
(usual,), _ = hide(1, [6])
(narrow,), _ = hide(1, [6], 0.0, True)
(waved,), _ = hide(1, [3], 0.03)
told["other"] = bool(np.abs(narrow.exact.trunk_p - usual.exact.trunk_p).max() > 0.01)
told["moved"] = float(np.abs(waved.p.corners - first.p.corners).max())
told["restored"] = limits == {name: value for name, value in vars(groundtruth).items() if name.isupper()}
print(json.dumps(told))
"""


def run(script: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, str(FOLDER / f"{script}.py"), *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=280)


def test_hidden_pairs_and_where_their_trunks_are_lost() -> None:
    done = subprocess.run([sys.executable, "-c", PARTS, str(FOLDER)], capture_output=True, text=True, timeout=280)
    assert done.returncode == 0, done.stderr
    printed = json.loads(done.stdout)
    # Wilson's interval of 9 in 10, as in any table; the ends stay within 0 … 1 and never shrink to a point.
    assert printed["wilson"] == pytest.approx([0.5958, 0.9821], abs=1e-4)
    assert printed["all"] == pytest.approx([0.8389, 1.0], abs=1e-4)
    assert printed["none"] == pytest.approx([0.0, 0.1611], abs=1e-4)
    # The true trunks lie on the outlines of the pictures, to about a pixel, and are still conjugate.
    assert max(printed["off"]) < 0.03
    assert min(printed["areas"]) > 0.0
    assert max(printed["edges"]) < 0.02
    assert printed["near"] == [""] * 8
    assert (printed["area"], printed["congruency"]) == ("area", "congruency")
    assert printed["convex"] == "too few convex points for n"
    assert printed["changed"] == [0.07, 15.0, 64, 3]
    # Other limits draw other pairs, and are put back; waves move the shapes a little.
    assert printed["other"]
    assert printed["restored"]
    assert 0.002 < printed["moved"] < 0.1


@pytest.mark.system
def test_recovery_counts_every_hidden_shape(tmp_path: Path) -> None:
    root = pictures(tmp_path / "pictures", range(6))
    figures, drawn = tmp_path / "figures.json", tmp_path / "drawn"
    more = ("--pairs", "2", "--pieces", "3,4", "--keep", "5", "--few", "2")
    done = run("recovery", "--root", str(root), *more, "--json", str(figures), "--draw", str(drawn))
    assert done.returncode == 0, done.stderr
    written = json.loads(figures.read_text(encoding="utf-8"))
    assert (written["format"], written["pairs"], written["shapes"], written["refused"]) == (1, 2, 10, 0)
    assert [recovery["name"] for recovery in written["found"]] == [
        "hidden000-p",
        "hidden000-q",
        "hidden001-p",
        "hidden001-q",
    ]
    by_name = {row["name"]: row for row in written["figures"]}
    for name, row in by_name.items():
        assert row["of"] == (2 if name.startswith("IoU ≥") else 4), name
        assert 0 <= row["good"] <= row["of"]
        assert row["low"] <= row["good"] / row["of"] <= row["high"]
        assert sum(good for good, _ in row["by_n"].values()) == row["good"]
        assert name in done.stdout
    for recovery in written["found"]:
        assert recovery["cross_rank"] is not None
        assert recovery["final_rank"] is None or recovery["cross_rank"] <= 2
        assert (recovery["cause"] == "") == (recovery["final_rank"] == 1)
    # Exact pairs among polygons at random: nothing else comes near.
    assert by_name["CRS: partner first"]["good"] == 4
    assert by_name["construction: partner first by IoU"]["good"] == 4
    assert by_name["IoU ≥ 0.999: polygons, trunks given"]["good"] == 2
    assert by_name["IoU ≥ 0.985: pictures, trunks found"]["good"] == 2
    assert written["causes"] == {}
    assert {path.name for path in drawn.iterdir()} == {
        f"far-hidden00{k}{end}.png" for k in (0, 1) for end in ("", "-trunks")
    }


@pytest.mark.system
def test_intricate_shapes_are_searched_in_every_way_asked_for(tmp_path: Path) -> None:
    root, figures = pictures(tmp_path / "pictures", range(8)), tmp_path / "figures.json"
    more = ("--classes", "kind0,kind2", "--each", "1", "--among", "6", "--ways", "0,3", "--json", str(figures))
    done = run("complex_shapes", "--root", str(root), *more)
    assert done.returncode == 0, done.stderr
    written = json.loads(figures.read_text(encoding="utf-8"))
    assert [way["way"] for way in written["ways"]] == ["default", "spacing 22"]
    for way in written["ways"]:
        assert [shape["cls"] for shape in way["shapes"]] == ["kind0", "kind2"]
        for shape in way["shapes"]:
            assert shape["partner"].rsplit("-", 1)[0] != shape["cls"]
            assert 3 <= shape["n"] <= shape["most"] <= shape["convex"]
            assert 0.5 < shape["iou"] <= 1.0
    coarse, fine = (np.array([shape["quick"] for shape in way["shapes"]]) for way in written["ways"])
    assert (fine > coarse).all()  # denser boundary points give more trunks
    assert all(word in done.stdout for word in ("kind0", "kind2", "default", "spacing 22"))


@pytest.mark.system
def test_wrong_arguments_are_refused(tmp_path: Path) -> None:
    for arguments, words in (
        (("recovery", "--root", str(tmp_path)), "no pictures under"),
        (("recovery", "--set", "trunks.tau=1"), "trunks.tau=1: give trunks.NAME=VALUE"),
        (("complex_shapes", "--root", str(tmp_path), "--classes", "octopus"), "no pictures octopus-"),
    ):
        done = run(*arguments)
        assert done.returncode == 2
        assert words in done.stderr

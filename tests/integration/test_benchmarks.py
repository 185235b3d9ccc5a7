"""The benchmark scripts run, agree with their references, and write what they print; no times."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from small_runs import pictures

FOLDER = Path(__file__).parents[2] / "benchmarks"

COMPARED = {"QCRS", "CRS", "dataflow of QCRS"}
"""Steps that run beside a slower or plainer way to the same result."""


def run(script: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, str(FOLDER / f"{script}.py"), *arguments], capture_output=True, text=True, timeout=280
    )


@pytest.mark.system
def test_small_size_measures_every_step(tmp_path: Path) -> None:
    done = run("run", "--size", "small", "--json", str(tmp_path / "figures.json"))
    assert done.returncode == 0, done.stderr
    figures = json.loads((tmp_path / "figures.json").read_text(encoding="utf-8"))
    assert figures["format"] == 2
    assert all(rate > 0 for rate in figures["rates"].values())
    steps = {step["step"]: step for step in figures["steps"]}
    assert list(steps) == [
        "ingest",
        "reversibility score",
        "quick trunks",
        "full trunks",
        "stacks for QCRS",
        "QCRS",
        "QCRS by brute force",
        "CRS",
        "construction",
        "dataflow of QCRS",
    ]
    assert all(name in done.stdout for name in steps)
    assert all(step["failed"] == 0 and step["mean_ms"] > 0 for step in steps.values())
    assert {name: step["items"] for name, step in steps.items() if step["per"] == "pair"} == {
        "QCRS": 28,
        "QCRS by brute force": 6,
        "CRS": 2,
        "construction": 2,
        "dataflow of QCRS": 28,
    }
    assert {name for name, step in steps.items() if step["agree"]} == COMPARED
    for name, step in steps.items():
        assert step["floor"]["ms"] > 0, name
        assert step["floor"]["says"]
        assert step["floor"]["counts"]
        assert step["bounded_by"]
        assert (step["met"] is None) == (step["target_ms"] is None)
        assert (step["ratio"] is None) == (step["reference"] == "")


WRONG = """
import sys
sys.path.insert(0, sys.argv[1])
import run, pair_steps
from dataclasses import replace
right = pair_steps.brute_force
def wrong(*arguments):
    found = right(*arguments)
    return replace(found, **{sys.argv[2]: found.__dict__[sys.argv[2]] + float(sys.argv[3])})
pair_steps.brute_force = wrong
run.cross_steps = run.dataflow_steps = lambda *arguments: []
sys.exit(run.main(["--size", "small"]))
"""
"""The benchmark with a brute force that errs in one field."""


@pytest.mark.system
@pytest.mark.parametrize(("field", "error"), [("score", "1e-11"), ("trunk_j", "1")])
def test_a_reference_that_disagrees_is_an_exit_code(field: str, error: str) -> None:
    command = [sys.executable, "-c", WRONG, str(FOLDER), field, error]
    done = subprocess.run(command, capture_output=True, text=True, timeout=280)
    assert done.returncode == 1, done.stderr
    assert "NOT" in done.stdout
    assert "not the same as the reference: QCRS" in done.stderr


def test_an_empty_folder_is_refused(tmp_path: Path) -> None:
    for script in ("run", "growth"):
        done = run(script, "--root", str(tmp_path))
        assert done.returncode == 2
        assert "fewer than two pictures" in done.stderr


@pytest.mark.system
def test_a_collection_grows_and_is_measured_at_every_size(tmp_path: Path) -> None:
    root = pictures(tmp_path / "pictures", range(5))
    figures, plot = tmp_path / "growth.json", tmp_path / "growth.svg"
    done = run(
        *("growth", "--root", str(root), "--sizes", "12,8", "--batch", "4", "--workers", "1", "--fraction", "0.1"),
        *("--json", str(figures), "--plot", str(plot)),
    )
    assert done.returncode == 0, done.stderr
    measured = json.loads(figures.read_text(encoding="utf-8"))
    assert measured["refused"] == 0
    costs = [(cost["way"], cost["shapes"], cost["pairs"], cost["pairs_scored"]) for cost in measured["costs"]]
    # 8 and 12 shapes are 3 and 6 blocks, fewer than an estimate rests on: all run.
    assert costs == [
        ("all pairs", 8, 28, 28),
        ("top 10", 8, 28, 56),  # ten partners are more than there are: all are compared, from either side
        ("one more shape", 8, 8, 8),
        ("all pairs", 12, 66, 66),
        ("top 10", 12, 66, 132),
        ("one more shape", 12, 12, 12),
    ]
    assert not any(cost["estimated"] for cost in measured["costs"])
    assert plot.read_text(encoding="utf-8").startswith("<?xml")


@pytest.mark.system
def test_each_bound_leaves_fewer_trunk_pairs_and_a_greater_distance_more(tmp_path: Path) -> None:
    root = pictures(tmp_path / "pictures", range(5))
    done = run("prunes", "--root", str(root), "--shapes", "5", "--trunks", "200", "--distances", "0.3,3,1e9")
    assert done.returncode == 0, done.stderr
    rows = [line.split() for line in done.stdout.splitlines() if line.startswith("  ")]
    counts = [int(row[-2].replace(",", "")) for row in rows]
    near, far, everything = counts[:7], counts[7:14], counts[14:]
    assert near == sorted(near, reverse=True) and far == sorted(far, reverse=True)
    assert near[-1] < far[-1] < everything[-1] == everything[0] == near[0]


@pytest.mark.system
def test_the_approximate_search_is_measured_against_the_exact_one(tmp_path: Path) -> None:
    root = pictures(tmp_path / "pictures", range(6))
    figures, plot = tmp_path / "recall.json", tmp_path / "recall.svg"
    done = run(
        *(
            "recall",
            "--root",
            str(root),
            "--sizes",
            "6,18",
            "--part",
            "6",
            "--batches",
            "2",
            "--batch",
            "2",
            "--k",
            "3",
        ),
        *("--json", str(figures), "--plot", str(plot)),
    )
    assert done.returncode == 0, done.stderr
    one, three = json.loads(figures.read_text(encoding="utf-8"))
    # A collection of one part is searched exactly; a batch of it is asked once.
    assert (one["shapes"], one["asked"], one["recall"], one["low_scores"]) == (6, 2, 1.0, 0.0)
    assert (three["shapes"], three["asked"]) == (18, 4) and 0.5 < three["least_recall"] <= three["recall"] <= 1.0
    assert plot.read_text(encoding="utf-8").startswith("<?xml")


@pytest.mark.system
def test_the_stages_that_score_are_measured_in_every_mode(tmp_path: Path) -> None:
    root, figures = pictures(tmp_path / "pictures", range(6)), tmp_path / "stages.json"
    done = run("search_stages", "--root", str(root), "--sizes", "6", "--tasks", "1", "--json", str(figures))
    assert done.returncode == 0, done.stderr
    costs = {(cost["mode"], cost["stage"]): cost for cost in json.loads(figures.read_text(encoding="utf-8"))}
    # So few shapes are in one part of the index: there is nothing beyond it.
    assert {stage for mode, stage in costs if mode == "topk"} == {"shards", "partners"}
    assert all(cost["shapes"] == 6 and cost["share"] == 1.0 for cost in costs.values())


@pytest.mark.system
def test_an_added_shape_is_measured_with_older_searches_and_without(tmp_path: Path) -> None:
    root, figures = pictures(tmp_path / "pictures", range(6)), tmp_path / "adding.json"
    done = run("adding", "--root", str(root), "--sizes", "6", "--simulate", "6", "--json", str(figures))
    assert done.returncode == 0, done.stderr
    costs = json.loads(figures.read_text(encoding="utf-8"))
    assert [cost["stage"] for cost in costs] == ["shards", "partners"]
    assert all(cost["missing"] == cost["items"] and cost["read_mb"] > 0 < cost["anew_s"] for cost in costs)


@pytest.mark.system
def test_starts_are_measured_beside_python_and_numpy(tmp_path: Path) -> None:
    done = run("start", "--processes", "1", "--json", str(tmp_path / "figures.json"))
    assert done.returncode == 0, done.stderr
    starts = json.loads((tmp_path / "figures.json").read_text(encoding="utf-8"))["starts"]
    assert all(name in done.stdout for name in starts)
    assert {"python -c pass", "riot --help", "riot show FILE", "python -m pipeline.run --plan"} <= starts.keys()
    for figures in starts.values():
        assert 0.0 < figures["cpu_min"] <= figures["cpu_median"] and 0.0 < figures["wall_min"] <= figures["wall_median"]


def test_a_run_that_is_not_finished_with_this_code_is_not_measured(tmp_path: Path) -> None:
    record = {"configuration": {"batch": 4, "cluster": {"kind": "sync"}}, "store": str(tmp_path / "store")}
    folder = tmp_path / "outputs" / "sample"
    folder.mkdir(parents=True)
    (folder / "run.json").write_text(json.dumps(record), encoding="utf-8")
    done = run("start", "--run", str(folder))
    assert done.returncode == 1 and "no run that is finished with this code" in done.stderr


@pytest.mark.system
def test_two_readings_of_silhouettes_are_compared(tmp_path: Path) -> None:
    folder, saved = tmp_path / "pictures", tmp_path / "old.npz"
    folder.mkdir()
    head = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9">'
    (folder / "plain.svg").write_text(f'{head}<path d="M1 1h7v3h-7z"/></svg>')
    (folder / "faint.svg").write_text(f'{head}<path opacity=".5" d="M1 1h7v3h-7z"/></svg>')
    (folder / "text.svg").write_text(f"{head}<text>A</text></svg>")
    assert run("reading", "--root", str(folder), "--save", str(saved)).returncode == 0
    (folder / "plain.svg").write_text(f'{head}<path d="M1 1h7v5h-7z"/></svg>')
    done = run("reading", "--root", str(folder), "--against", str(saved), "--fine")
    assert done.returncode == 0, done.stderr
    assert "3 files: 1 paths, 1 refused: unsupported, 1 rendered" in done.stdout
    assert "1 of 2 differ" in done.stdout and "rendered outlines" in done.stdout

"""The benchmark script runs, agrees with its references, and writes what it prints."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

RUN = Path(__file__).parents[2] / "benchmarks" / "run.py"


def run(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, str(RUN), *arguments], capture_output=True, text=True, timeout=280)


def test_small_size_measures_every_step(tmp_path: Path) -> None:
    done = run("--size", "small", "--json", str(tmp_path / "figures.json"))
    assert done.returncode == 0, done.stderr
    figures = json.loads((tmp_path / "figures.json").read_text(encoding="utf-8"))
    steps = {step["step"]: step for step in figures["steps"]}
    assert list(steps) == [
        "ingest",
        "reversibility",
        "quick trunks",
        "full trunks",
        "qcrs",
        "qcrs, brute force",
        "crs",
        "construct",
    ]
    assert all(name in done.stdout for name in steps)
    assert all(step["failed"] == 0 and step["median_ms"] > 0 for step in steps.values())
    assert steps["qcrs"]["items"] == 28
    assert steps["qcrs"]["ratio"] < 1, "pruning must not cost more than it saves"
    assert steps["crs"]["ratio"] < 0.01, "best-first evaluates few area terms"


def test_an_empty_folder_is_refused(tmp_path: Path) -> None:
    done = run("--root", str(tmp_path))
    assert done.returncode == 2
    assert "fewer than two pictures" in done.stderr

"""The benchmark of both construction methods runs and writes what it prints; no times."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from riot.groundtruth.pairs import exact_pair, exact_transform
from riot.transform.riot_file import save

SCRIPT = Path(__file__).parents[2] / "benchmarks" / "methods.py"


def run(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, str(SCRIPT), *arguments], capture_output=True, text=True, timeout=280)


@pytest.mark.system
def test_both_methods_are_compared_on_the_trunks_of_a_run(tmp_path: Path) -> None:
    for seed in (1, 2):
        save(exact_transform(exact_pair(4, seed)), tmp_path / f"{seed}.riot")
    done = run("--transforms", str(tmp_path), "--pairs", "2", "--json", str(tmp_path / "figures.json"))
    assert done.returncode == 0, done.stderr
    measured = json.loads((tmp_path / "figures.json").read_text(encoding="utf-8"))
    assert (measured["format"], measured["source"], len(measured["pairs"])) == (1, "transforms", 2)
    for pair in measured["pairs"]:
        assert list(pair["ways"]) == ["paper", "exact", "exact, refined", "exact, bent"]
        for way, figures in pair["ways"].items():
            assert figures["iou"] > 0.99, way
            left = figures["gaps"] + figures["overlaps"] + figures["outside"]
            assert left < (2e-3 if way == "paper" else 1e-9), way
            assert figures["certified"] or way == "paper"
    for way, quantiles in measured["quantiles"].items():
        assert quantiles["iou"]["worst"] <= quantiles["iou"]["median"], way
        assert quantiles["gaps"]["median"] <= quantiles["gaps"]["worst"], way
        assert way.split(",")[0] in done.stdout
    assert "exact: 0 refused, 2 certified" in done.stdout


def test_folders_without_transforms_or_pictures_are_refused(tmp_path: Path) -> None:
    for option, words in (("--transforms", "no .riot file"), ("--root", "fewer than two pictures")):
        done = run(option, str(tmp_path))
        assert done.returncode == 2
        assert words in done.stderr

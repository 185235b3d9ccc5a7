"""A quick start: whoever only looks at keys loads nothing that computes."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from small_runs import CLEAN, command

SAY_LOADED = """
import sys
from pipeline.run import main
code = main(sys.argv[1:])
print("loaded", *{name.partition(".")[0] for name in sys.modules})
sys.exit(code)
"""

COMPUTES = {"numba", "scipy", "shapely", "skimage", "matplotlib", "pandas", "distributed"}


def loaded(*arguments: str) -> tuple[str, set[str]]:
    """What a run in a process of its own says, and the top-level packages that it has loaded at its end."""
    done = subprocess.run([sys.executable, "-c", SAY_LOADED, *arguments], capture_output=True, text=True)
    assert done.returncode == CLEAN, done.stderr
    said, _, names = done.stdout.rpartition("loaded")
    assert {"pipeline", "numpy"} <= set(names.split())
    return said, set(names.split())


@pytest.mark.parametrize("more", [(), ("qcrs.mode=topk",)], ids=["all pairs", "topk"])
def test_a_plan_loads_no_numeric_code(root: Path, tmp_path: Path, more: tuple[str, ...]) -> None:
    said, names = loaded(*command(tmp_path, root, "--plan", *more)[3:])
    assert "Plan: nothing was run" in said and not names & {*COMPUTES, "pyarrow"}


def test_nor_does_a_run_that_is_finished(copied: Path, root: Path) -> None:
    said, names = loaded(*command(copied, root, "cluster=sync")[3:])
    assert "Everything cached" in said and not names & COMPUTES

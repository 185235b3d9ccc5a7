"""A quick start: what only looks at keys loads nothing that computes."""

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

HEAVY = {"numba", "scipy", "shapely", "skimage", "matplotlib", "pandas", "pyarrow", "distributed"}


@pytest.mark.parametrize("more", [(), ("qcrs.mode=topk",)], ids=["all pairs", "topk"])
def test_a_plan_loads_no_numeric_code(root: Path, tmp_path: Path, more: tuple[str, ...]) -> None:
    arguments = command(tmp_path, root, "--plan", *more)[3:]
    done = subprocess.run([sys.executable, "-c", SAY_LOADED, *arguments], capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == CLEAN and "Plan: nothing was run" in done.stdout, done.stderr
    loaded = set(done.stdout.splitlines()[-1].split())
    assert {"loaded", "pipeline", "numpy"} <= loaded
    assert not loaded & HEAVY

"""A quick start: whoever only looks at keys loads nothing that computes."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from small_runs import CLEAN, command

from riot.groundtruth.pairs import exact_pair, exact_transform
from riot.motion.planner import with_motion
from riot.transform.riot_file import save

SAY_LOADED = """
import sys
from {module} import main
code = main(sys.argv[1:])
print("loaded", *{{name.partition(".")[0] for name in sys.modules}})
sys.exit(code)
"""

COMPUTES = {"numba", "scipy", "shapely", "skimage", "matplotlib", "pandas", "distributed"}


def loaded(*arguments: str, module: str = "pipeline.run") -> tuple[str, set[str]]:
    """What a program in a process of its own says, and the top-level packages that it has loaded at its end."""
    code = SAY_LOADED.format(module=module)
    done = subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True)
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


def test_showing_a_transform_loads_what_finds_centre_lines_only_for_who_asks(tmp_path: Path) -> None:
    save(with_motion(exact_transform(exact_pair(4, 3))), tmp_path / "exact.riot")
    said, names = loaded("show", str(tmp_path / "exact.riot"), module="pipeline.cli.main")
    assert "certificate: passed" in said and "centre line" not in said
    assert not names & {"skimage", "scipy", "matplotlib", "rich", "hydra"}
    said, names = loaded("show", str(tmp_path / "exact.riot"), "--verbose", module="pipeline.cli.main")
    assert "centre line kept" in said and "centre line inside" in said and "skimage" in names
    said, _ = loaded("show", str(tmp_path / "exact.riot"), "--json", module="pipeline.cli.main")
    assert "centreline_recall" in said and "centreline_precision" in said

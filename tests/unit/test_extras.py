"""What a smaller installation lacks: whatever needs it names the extra that brings it, in one sentence."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tomllib
from functools import cache
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

from pipeline.config.cluster import ClusterConfig
from pipeline.errors import StartError
from pipeline.exit_codes import BAD_START
from pipeline.run import main
from pipeline.runtime import clusters
from pipeline.runtime.clusters import open_cluster
from pipeline.store.filesystem.choose import open_files
from pipeline.store.location import Url
from riot.errors import MissingExtraError, needs_extra

ROOT = Path(__file__).parents[2]
EXTRAS = ("mine", "print", "film", "s3", "slurm", "notebook")

BASE = {"riot", "riot.cli.make", "riot.cli.show", "riot.cli.trunks", "riot.methods", "pipeline", "pipeline.cli.main"}
"""Modules that need no extra."""

IMPORT_ALL = """
import importlib, json, sys

absent, modules = map(json.loads, sys.argv[1:])

class Nowhere:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in absent:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Nowhere())
refused = {}
for module in modules:
    try:
        importlib.import_module(module)
    except Exception as error:
        refused[module] = [type(error).__name__, getattr(error, "extra", ""), getattr(error, "package", str(error))]
print(json.dumps(refused))
"""


@cache
def extras() -> dict[str, set[str]]:
    """The packages, as they are imported, of each extra."""
    with (ROOT / "pyproject.toml").open("rb") as stream:
        declared = tomllib.load(stream)["project"]["optional-dependencies"]
    imported: dict[str, set[str]] = {}
    for package, distributions in packages_distributions().items():
        for distribution in distributions:
            imported.setdefault(re.sub(r"[-_.]+", "-", distribution).lower(), set()).add(package)

    def packages(extra: str) -> set[str]:
        names = set()
        for requirement in declared[extra]:
            if own := re.match(r"riot-shapes\[(.*)\]", requirement):
                names.update(*(packages(other) for other in own[1].split(",")))
            else:
                name = re.split(r"[\[<>=]", requirement)[0]
                names |= imported.get(name, {name.replace("-", "_")})
        return {name for name in names if not name.startswith("_")}

    return {extra: packages(extra) for extra in EXTRAS}


def modules() -> list[str]:
    """All modules but those of the commands, which the program loads (tests/integration/test_wheel.py)."""
    names = []
    for package in ("riot", "pipeline"):
        for path in (ROOT / package).rglob("*.py"):
            parts = path.relative_to(ROOT).with_suffix("").parts
            names.append(".".join(parts[:-1] if parts[-1] == "__init__" else parts))
    return sorted(name for name in names if not name.startswith("pipeline.cli.") or name in BASE)


def test_each_module_loads_without_extras_or_names_the_one_that_it_needs() -> None:
    absent = sorted(set().union(*extras().values()) | {"omegaconf"})
    assert {"dask", "hydra", "pyarrow", "manifold3d", "s3fs", "dask_jobqueue"} <= set(absent)
    command = [sys.executable, "-c", IMPORT_ALL, json.dumps(absent), json.dumps(modules())]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, timeout=240)
    assert done.returncode == 0, done.stderr
    refused = json.loads(done.stdout)
    assert {"pipeline.flow", "riot.fabricate.solid"} <= refused.keys() and not BASE & refused.keys()
    for module, (error, extra, package) in refused.items():
        assert error == MissingExtraError.__name__, (module, error, package)
        assert package in extras()[extra], (module, extra, package)


def test_puzzles_are_refused_before_anything_is_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "manifold3d", None)
    where = (f"outputs={tmp_path / 'outputs'}", f"store={tmp_path / 'store'}", "cluster=sync")
    assert main(["fabricate.top=1", *where]) == BAD_START
    out, err = capsys.readouterr()
    expected = "Cannot start: fabricate.top=1: this needs the package manifold3d, which is not installed: "
    assert (out, err) == ("", f"{expected}pip install 'riot-shapes[print]'\n")
    assert not (tmp_path / "store").exists()


def test_an_object_store_and_slurm_name_their_extras(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "s3fs", None)
    with pytest.raises(StartError, match=r"^s3://bucket/store: .*package s3fs, .* 'riot-shapes\[s3\]'$"):
        open_files(Url("s3://bucket/store"))
    for program in ("sbatch", "scancel"):
        (tmp_path / program).touch(mode=0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setitem(sys.modules, "dask_jobqueue", None)
    for name in [name for name in sys.modules if name == "pipeline.runtime.clusters.slurm_jobs"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.delitem(vars(clusters), "slurm_jobs", raising=False)  # hasattr would load it
    with (
        pytest.raises(StartError, match=r"^cluster=slurm: .*package dask_jobqueue, .* 'riot-shapes\[slurm\]'$"),
        open_cluster(ClusterConfig(kind="slurm"), tmp_path, lambda event: None),
    ):
        pass


def test_a_module_of_ours_that_is_missing_is_no_missing_package() -> None:
    with pytest.raises(MissingExtraError) as inner, needs_extra("mine"), needs_extra("print"):
        raise ModuleNotFoundError(name="manifold3d.parts")
    assert (inner.value.extra, inner.value.package) == ("print", "manifold3d")

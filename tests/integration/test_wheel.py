"""A wheel has everything that a run needs, and runs without the checkout."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from fenced import ROOT

pytestmark = pytest.mark.system

pytest.importorskip("setuptools", minversion="77", reason="setuptools is too old to build the wheel (extra dev)")

SOURCES = ("riot", "pipeline", "conf")
FILES = ("pyproject.toml", "setup.py", "README.md", "LICENSE")

SHOW_ORIGIN = """
import sys
import pipeline, riot
from pipeline.run import main
code = main(sys.argv[1:])
print(pipeline.__file__, riot.__file__, sep="\\n")
sys.exit(code)
"""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel of a copy of the sources: what earlier builds have left beside them must not get into it."""
    folder = tmp_path_factory.mktemp("wheel")
    source = folder / "source"
    source.mkdir()
    for name in SOURCES:
        shutil.copytree(ROOT / name, source / name, ignore=shutil.ignore_patterns("__pycache__", ".*"))
    for name in FILES:
        shutil.copy(ROOT / name, source)
    pip("wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", str(folder), str(source))
    (built,) = folder.glob("*.whl")
    return built


def pip(*arguments: str) -> None:
    command = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check", "--no-input", *arguments]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_wheel_has_every_file_of_the_packages_and_of_conf(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        names = {name for name in archive.namelist() if ".dist-info/" not in name}
    expected = {
        str(path.relative_to(ROOT))
        for package in ("riot", "pipeline")
        for path in (ROOT / package).rglob("*")
        if path.is_file() and "__pycache__" not in path.parts and path.suffix != ".md"
    }
    conf = {f"pipeline/{path.relative_to(ROOT)}" for path in (ROOT / "conf").rglob("*.yaml")}
    assert names == expected | conf
    suffixes = {Path(name).suffix for name in names}
    assert {".py", ".pyi", ".typed", ".yaml", ".csv", ".html", ".css", ".js", ".svg"} <= suffixes


@pytest.fixture(scope="module")
def site(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    target = tmp_path_factory.mktemp("site")
    pip("install", "--no-deps", "--no-index", "--target", str(target), str(wheel))
    return target


@pytest.mark.parametrize("arguments", [("--plan",), ("--plan", "select=paper", "cluster=sync"), ("--help",)])
def test_an_installed_wheel_runs_without_the_checkout(site: Path, tmp_path: Path, arguments: tuple[str, ...]) -> None:
    done = subprocess.run(
        [sys.executable, "-c", SHOW_ORIGIN, *arguments],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(site)},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    *printed, pipeline_file, riot_file = done.stdout.splitlines()
    assert Path(pipeline_file) == site / "pipeline" / "__init__.py" and Path(riot_file) == site / "riot" / "__init__.py"
    expected = "usage: python -m pipeline.run" if arguments == ("--help",) else "Plan: nothing was run"
    assert printed[0].startswith(expected)
    assert list(tmp_path.iterdir()) == []

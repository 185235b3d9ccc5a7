"""A wheel has all that its users need: installed in an environment of its own, which grows, far from the checkout.

The tests run in the order of this file: those of the base come before those for which extras are installed.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from fenced import ROOT
from PIL import Image
from small_runs import BAD_START, CLEAN, QUICK, pictures

from pipeline.datasets import sample

pytestmark = [pytest.mark.system, pytest.mark.timeout(900)]  # packages are installed, and the kernels compiled, once

SOURCES = ("riot", "pipeline", "studio", "conf")
FILES = ("pyproject.toml", "setup.py", "README.md", "LICENSE")

PAIR = ("pair00-a", "pair00-b")
"""Two pictures of the sample that turn into each other exactly."""

LOOK = """
import importlib.util, riot, pipeline
print(riot.__file__, pipeline.__file__, riot.Shape.from_polygon([(0, 0), (1, 0), (0, 1)]).name)
print(*(name for name in ("dask", "pyarrow", "hydra", "manifold3d", "s3fs") if importlib.util.find_spec(name)))
"""


class Installation:
    """An environment that has the wheel, and an empty folder to work in."""

    def __init__(self, folder: Path) -> None:
        self.work = folder / "work"
        self.work.mkdir(parents=True)
        pictures(folder / "given", range(1))
        (folder / "given" / "a.stl").write_text("solid\nendsolid\n", encoding="utf-8")
        self.bin = folder / "environment" / ("Scripts" if os.name == "nt" else "bin")
        subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(folder / "environment")], check=True)
        kept = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "NUMBA_"))}
        self.environment = {**kept, "XDG_CACHE_HOME": str(folder / "cache")}

    def install(self, what: str) -> None:
        """Install a wheel, with extras in brackets, and what it needs, in the versions of the constraints."""
        pip("--python", str(self.bin / "python"), "install", "--constraint", str(ROOT / "constraints.txt"), what)

    def run(self, program: str, *arguments: str) -> subprocess.CompletedProcess[str]:
        """Run a program of the environment in the folder."""
        line = [str(self.bin / program), *arguments]
        return subprocess.run(
            line, cwd=self.work, env=self.environment, capture_output=True, text=True, stdin=subprocess.DEVNULL
        )

    def succeed(self, program: str, *arguments: str) -> str:
        """`run`, which must end well; returns what is printed."""
        done = self.run(program, *arguments)
        assert done.returncode == CLEAN, done.stdout + done.stderr
        return done.stdout


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
    pip("wheel", "--no-deps", "--wheel-dir", str(folder), str(source))
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
        for package in ("riot", "pipeline", "studio")
        for path in (ROOT / package).rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
        if path.suffix != ".md" and path.name != "jsconfig.json"  # for who works on the code
    }
    conf = {f"pipeline/{path.relative_to(ROOT)}" for path in (ROOT / "conf").rglob("*.yaml")}
    assert names == expected | conf
    suffixes = {Path(name).suffix for name in names}
    assert {".py", ".pyi", ".typed", ".yaml", ".csv", ".html", ".css", ".js", ".svg"} <= suffixes


@pytest.fixture(scope="module")
def base(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Installation:
    installation = Installation(tmp_path_factory.mktemp("installed"))
    installation.install(str(wheel))
    return installation


def test_the_base_is_the_library_alone(base: Installation) -> None:
    files, extras = base.succeed("python", "-c", LOOK).splitlines()
    assert all(str(base.bin.parent) in file for file in files.split()[:2])
    assert extras == ""
    assert base.succeed("riot", "--version").startswith("riot ")
    assert base.succeed("python", "-m", "pipeline.cli.main", "--help").startswith("usage: riot")
    assert list(base.work.iterdir()) == []


@pytest.mark.parametrize(
    ("command", "extra"),
    [
        ("riot mine", "mine"),
        ("riot mine --plan", "mine"),
        ("riot mine --help", "mine"),
        ("riot study list", "mine"),
        ("riot cache du", "mine"),
        ("riot match a.png --in outputs/sample", "mine"),
        ("python -m pipeline.run", "mine"),
        ("python -m pipeline.study quiz", "mine"),
        ("python -c import~pipeline.flow", "mine"),
        ("python -c import~pipeline.match.search", "mine"),
        ("riot print a.riot -o out", "print"),
        ("riot slices ../given/a.stl --into ../given/kind0-0.png -o out", "print"),
        pytest.param(
            *("riot make a.png b.png -o out --mp4", "film"),
            marks=pytest.mark.skipif(shutil.which("ffmpeg") is not None, reason="ffmpeg is installed"),
        ),
    ],
)
def test_what_needs_an_extra_says_so_in_a_line(command: str, extra: str, base: Installation) -> None:
    program, *arguments = command.split()
    done = base.run(program, *(argument.replace("~", " ") for argument in arguments))
    sentence = f"which is not installed: pip install 'riot-shapes[{extra}]'"
    if "-c" in arguments:  # a library raises
        assert done.returncode == 1 and "MissingExtraError: this needs the package " in done.stderr
        assert done.stderr.rstrip().endswith(sentence)
        return
    assert (done.returncode, done.stdout) == (BAD_START, "")
    assert done.stderr.count("\n") == 1 and sentence in done.stderr
    assert list(base.work.iterdir()) == []


@pytest.fixture(scope="module")
def transform(base: Installation) -> Path:
    """A transform that the base makes: the first program to need kernels compiles them."""
    sources = {name: source for name, _, source, _ in sample.definitions()}
    for name in PAIR:
        Image.fromarray(sample.picture(sources[name]).astype("uint8")).save(base.work / f"{name}.png")
    base.succeed("riot", "make", *(f"{name}.png" for name in PAIR), "-o", "out")
    return Path("out") / f"{'--'.join(PAIR)}.riot"


def test_the_base_makes_and_shows_a_transform(base: Installation, transform: Path) -> None:
    suffixes = {path.name.partition(".")[2] for path in (base.work / "out").iterdir()}
    assert suffixes == {"riot", "svg", "png", "strip.svg", "strip.png", "swing.svg"}
    shown = base.succeed("riot", "show", str(transform))
    assert "certificate: passed" in shown and all(name in shown for name in PAIR)
    assert json.loads(base.succeed("riot", "show", str(transform), "--json"))["certificate"]["passed"]


@pytest.fixture(scope="module")
def grown(base: Installation, transform: Path, wheel: Path) -> Installation:
    """The same environment, with extras; it has been used without them."""
    base.install(f"{wheel}[mine,print]")
    return base


@pytest.mark.parametrize("arguments", [("--plan",), ("--plan", "select=paper", "cluster=sync"), ("--help",)])
def test_a_plan_and_help_need_no_checkout_and_leave_nothing(arguments: tuple[str, ...], grown: Installation) -> None:
    before = sorted(grown.work.rglob("*"))
    printed = grown.succeed("python", "-m", "pipeline.run", *arguments)
    expected = "usage: python -m pipeline.run" if arguments == ("--help",) else "Plan: nothing was run"
    assert printed.startswith(expected)
    assert sorted(grown.work.rglob("*")) == before


def test_the_sample_is_mined(grown: Installation) -> None:
    printed = grown.succeed("python", "-m", "pipeline.run")
    outputs = grown.work / "outputs" / "sample"
    counts = json.loads((outputs / "run.json").read_text(encoding="utf-8"))["counts"]
    assert "Report:" in printed and counts["shapes"] == len(sample.definitions())
    made = len(list((outputs / "transforms").glob("*.riot")))
    assert 0 < counts["certified"] <= made <= counts["constructed"] <= counts["selected"]
    assert (outputs / "report.html").is_file() and (outputs / "gallery" / "index.html").is_file()


def test_a_folder_is_mined_and_studied(grown: Installation) -> None:
    pictures(grown.work / "pictures", range(6))
    data = ("+dataset=folder", "dataset.root=pictures")
    grown.succeed("python", "-m", "pipeline.run", *data, *QUICK)
    assert (grown.work / "outputs" / "folder" / "report.html").is_file()
    printed = grown.succeed("python", "-m", "pipeline.study", "distributions", *data, *QUICK, "samples=4")
    assert Path(printed.rpartition("Report: ")[2].strip()).name.endswith(".html")


def test_a_puzzle_is_printed(grown: Installation, transform: Path) -> None:
    grown.succeed("riot", "print", str(transform), "-o", "puzzle", "--fix", "--paper", "--dxf")
    suffixes = {path.suffix for path in (grown.work / "puzzle").rglob("*")}
    assert {".stl", ".3mf", ".dxf", ".svg", ".json"} <= suffixes

"""The program `riot`: one grammar for all commands, in help, messages, JSON, quiet and completion."""

from __future__ import annotations

import itertools
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

import pipeline.cache
import pipeline.fetch
import pipeline.run
import pipeline.study.__main__
from pipeline.cli.main import RIOT, main
from pipeline.study.registry import STUDIES
from riot.cli.command import Command, Group
from riot.cli.completion import SHELLS, script
from riot.groundtruth.pairs import exact_pair, exact_transform
from riot.transform.riot_file import save

WIDTH = 80
Main = Callable[[list[str]], int]
MODULES: dict[str, Main] = {
    "python -m pipeline.run": pipeline.run.main,
    "python -m pipeline.cache": pipeline.cache.main,
    "python -m pipeline.fetch": pipeline.fetch.main,
    "python -m pipeline.study": pipeline.study.__main__.main,
}


def paths(entry: Command | Group, path: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    yield path
    if isinstance(entry, Group):
        for name, below in entry.commands.items():
            yield from paths(below, (*path, name))


def ended(capsys: pytest.CaptureFixture[str], *arguments: str, program: Main = main) -> tuple[int, str, str]:
    code = program(list(arguments))
    printed = capsys.readouterr()
    return code, printed.out, printed.err


@pytest.fixture
def transform(tmp_path: Path) -> Path:
    """A file that `riot show` reads."""
    path = tmp_path / "pair.riot"
    save(exact_transform(exact_pair(3, 1)), path)
    return path


@pytest.mark.parametrize("path", list(paths(RIOT)), ids=" ".join)
def test_every_command_has_a_help_of_80_columns_and_the_version(
    path: tuple[str, ...], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", str(WIDTH))
    code, out, err = ended(capsys, *path, "--help")
    assert (code, err) == (0, "") and out.startswith(f"usage: {' '.join(('riot', *path))}")
    assert "--version" in out and "--quiet" in out and "--verbose" in out
    assert [line for line in out.splitlines() if len(line) > WIDTH] == []
    assert ended(capsys, *path, "--version") == ended(capsys, "--version")
    assert ended(capsys, *path, "--version")[1].startswith("riot ")


@pytest.mark.parametrize("program", MODULES)
def test_modules_are_the_same_programs_by_the_names_that_were_typed(
    program: str, capsys: pytest.CaptureFixture[str]
) -> None:
    code, out, _ = ended(capsys, "--help", program=MODULES[program])
    assert code == 0 and out.startswith(f"usage: {program}")
    assert ended(capsys, "--version", program=MODULES[program]) == ended(capsys, "--version")
    code, out, err = ended(capsys, "--quite", program=MODULES[program])
    assert (code, out) == (2, "") and "Did you mean --quiet?" in err
    assert f"`{program} --help`" in err


@pytest.mark.parametrize("study", STUDIES)
def test_the_help_of_a_study_lists_its_parameters_and_exit_codes(
    study: str, capsys: pytest.CaptureFixture[str]
) -> None:
    _, out, _ = ended(capsys, "study", study, "--help")
    assert "parameters of the study:" in out and "exit codes:" in out
    if study == "quiz":
        assert "pairs=16  (a whole number, 2 or more; ours)" in out and "Pairs that are shown" in out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("mkae",), "riot: mkae: no such command. Did you mean make?"),
        ((), "name a command"),
        (("--jsno",), "Did you mean --json?"),
        (("make", "--metod", "exact"), "riot make: --metod: no such option. Did you mean --method?"),
        (("cache", "verfy"), "riot cache: verfy: no such command. Did you mean verify?"),
        (("cache", "gc", "--dryrun"), "Did you mean --dry-run?"),
        (("study", "quizz"), "riot study: quizz: no such study. Did you mean quiz?"),
        (("mine", "--top", "3"), "riot mine: --top: no such option. Did you mean fabricate.top=… or select.top=…?"),
        (("mine", "--plann"), "Did you mean --plan?"),
        (("mine", "mpeg7"), "mpeg7: no name=value. Did you mean +dataset=mpeg7?"),
        (("mine", "selct.top=3"), "Did you mean select.top?"),
        (("study", "quiz", "pears=4"), "Did you mean pairs?"),
        (("trunks", "a.png", "b.png", "--pieces", "5..4"), "'5..4' is no range of numbers of pieces"),
        (("make", "a.png"), "riot make: the following arguments are required: -o/--output"),
        (("match", "a.png", "--in", "x", "--top", "0"), "argument --top: '0' is not a whole number above 0"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else None,
)
def test_mistakes_end_with_2_and_the_name_that_may_be_meant(
    arguments: tuple[str, ...], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    code, out, err = ended(capsys, *arguments)
    assert (code, out) == (2, "") and words in err


def test_messages_name_what_the_user_typed(tmp_path: Path, transform: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "text.png").write_text("no picture")
    code, _, err = ended(capsys, "make", str(tmp_path / "text.png"), str(tmp_path / "b.png"), "-o", str(tmp_path / "o"))
    assert code == 2 and "Shape." not in err and "convert it to PNG" in err
    code, _, err = ended(capsys, "print", str(transform), "-o", str(tmp_path / "o"), "--size", "-3")
    assert code == 2 and err.startswith("riot print: --size: must be") and "size_mm" not in err
    data = (f"dataset.root={tmp_path}", f"outputs={tmp_path / 'outputs'}")
    code, _, err = ended(capsys, "study", "quiz", "+dataset=folder", *data)
    assert code == 2 and "no finished run here; `riot mine +dataset=folder dataset.root=" in err and "--in" not in err


def test_missing_configuration_ends_with_2(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pipeline.config.conf_files.CONF", tmp_path / "conf")
    for arguments in (["mine", "--help"], ["mine"], ["mine", "--plan", "batch=8"]):
        code, out, err = ended(capsys, *arguments)
        assert (code, out) == (2, "") and "install the project again" in err


def test_facts_are_json_where_that_is_wanted(
    tmp_path: Path, transform: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "store" / "crs").mkdir(parents=True)
    Image.new("L", (40, 40)).save(tmp_path / "dark.png")
    for arguments, name in (
        (("show", str(transform)), "pieces"),
        (("show", str(transform), "--history"), "history"),
        (("mine", "--plan"), "stages"),
        (("mine", "--explain"), "stages"),
        (("study", "list"), "studies"),
        (("cache", "du"), "stages"),
        (("cache", "verify"), "damaged"),
        (("fetch", "manifest", str(tmp_path), "--to", str(tmp_path / "list.csv")), "pictures"),
    ):
        code, out, _ = ended(capsys, *arguments, "--json")
        document = json.loads(out)
        assert code == 0 and name in document, arguments
        words = itertools.takewhile(str.isalpha, arguments)
        assert (document["format"], document["version"]) == ("-".join(("riot", *words)), 1)
        assert ended(capsys, "--json", *arguments) == (0, out, "")
        code, out, err = ended(capsys, *arguments, "--quiet")
        assert (code, out, err) == (0, "", ""), arguments


def test_a_module_prints_the_same_documents_as_the_command(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "store").mkdir()
    for module, arguments in (("run", ["--plan"]), ("cache", ["du"]), ("study", ["list"])):
        command = "mine" if module == "run" else module
        code, out, _ = ended(capsys, command, *arguments, "--json")
        assert MODULES[f"python -m pipeline.{module}"]([*arguments, "--json"]) == code == 0
        assert capsys.readouterr().out == out


def test_the_commands_of_two_shapes_hand_json_from_one_to_the_next(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def facts(*arguments: str) -> dict[str, Any]:
        code, out, err = ended(capsys, *arguments, "--json", "--quiet")
        assert (code, err) == (0, "")
        document: dict[str, Any] = json.loads(out)
        assert (document["format"], document["version"]) == (f"riot-{arguments[0]}", 1)
        return document

    inputs = []
    for name, path in (("house", "M1 8H8V4L4.5 1L1 4Z"), ("kite", "M4 1L8 4L4 9L1 4Z")):
        inputs.append(str(tmp_path / f"{name}.svg"))
        Path(inputs[-1]).write_text(
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9"><path d="{path}"/></svg>'
        )
    pairs = facts("trunks", *inputs)["trunk_pairs"]
    assert [pair["rank"] for pair in pairs] == list(range(1, len(pairs) + 1))
    best = max(range(len(pairs)), key=lambda k: min(pairs[k]["bound_p"], pairs[k]["bound_q"]))
    made = facts("make", *inputs, "-o", str(tmp_path / "made"), "--rank", str(best + 1))
    assert made["certificate"]["passed"] and made["pieces"] == pairs[best]["pieces"]
    for side, name in zip(made["inputs"], "pq", strict=True):
        assert 0.8 < side["iou"] <= side["bound"] == pytest.approx(pairs[best][f"bound_{name}"], abs=0.05)
    assert all(Path(file).is_file() for file in made["files"])
    printed = facts("print", made["files"][0], "-o", str(tmp_path / "parts"), "--size", "100")
    assert printed["puzzle"]["parameters"]["size_mm"] == 100.0
    assert all(Path(file).is_file() for file in printed["files"])


def test_show_films_the_motion(transform: Path, capsys: pytest.CaptureFixture[str]) -> None:
    film = transform.with_suffix(".gif")
    assert ended(capsys, "show", str(transform), "-o", str(film)) == ended(capsys, "show", str(transform))
    assert film.read_bytes()[:6] == b"GIF89a"
    code, out, err = ended(capsys, "show", str(transform), "-o", "film.txt")
    assert (code, out) == (2, "") and "ends in .gif or .mp4" in err


def test_verbose_tells_where_an_error_comes_from(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    absent = str(tmp_path / "absent.riot")
    assert "Traceback" not in ended(capsys, "show", absent)[2]
    code, out, err = ended(capsys, "show", absent, "--verbose")
    assert (code, out) == (2, "") and "Traceback" in err and f"riot show: {absent}" in err


@pytest.mark.parametrize("arguments", [("--help",), ("mine", "--help"), ("completion", "bash")], ids=" ".join)
def test_a_reader_that_goes_ends_the_program_quietly(arguments: tuple[str, ...]) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    command = [sys.executable, "-m", "pipeline.cli.main", *arguments]
    done = subprocess.run(command, stdout=writer, stderr=subprocess.PIPE, text=True, timeout=120)
    os.close(writer)
    assert (done.returncode, done.stderr) == (141, "")


def test_help_loads_no_library(tmp_path: Path) -> None:
    code = "import sys; from pipeline.cli.main import main; main(['--help']); print('loaded', *sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=120)
    loaded = {name.partition(".")[0] for name in done.stdout.rpartition("loaded ")[2].split()}
    assert not loaded & {"numpy", "rich", "hydra", "dask", "pyarrow", "numba", "scipy", "shapely"}


COMPLETE = """
{script}
COMP_LINE={line!r} COMP_POINT=${{#COMP_LINE}}
_riot
printf '%s\\n' "${{COMPREPLY[@]}}"
"""


@pytest.fixture(scope="module")
def bash(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], list[str]]:
    """What a real bash offers for a line that is typed so far."""
    if shutil.which("bash") is None:
        pytest.skip("no bash here")
    folder = tmp_path_factory.mktemp("bash")
    text = script(RIOT, "bash")
    Image.new("L", (4, 4)).save(folder / "bell.png")

    def complete(line: str) -> list[str]:
        (folder / "complete.sh").write_text(COMPLETE.format(script=text, line=line), encoding="utf-8")
        done = subprocess.run(
            ["bash", "complete.sh"], capture_output=True, text=True, check=True, cwd=folder, timeout=60
        )
        assert done.stderr == ""
        return [word for word in done.stdout.splitlines() if word]

    return complete


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("riot m", ["mine", "match", "make"]),
        ("riot cache ", ["du", "verify", "gc", "accept"]),
        ("riot cache gc --d", ["--dry-run"]),
        ("riot make --met", ["--method"]),
        ("riot make --method ", ["exact", "laplacian"]),
        ("riot make be", ["bell.png"]),
        ("riot make a.png b.png --pins be", ["bell.png"]),
        ("riot study qu", ["quiz"]),
        ("riot study quiz thr", ["threshold="]),
        ("riot mine +dataset=mp", ["mpeg7"]),
        ("riot mine select.t", ["select.top="]),
        ("riot mine --plan cluster=s", ["slurm", "ssh", "sync"]),
        ("riot mine fabricate.fix=", ["true", "false"]),
        ("riot mine dataset.root=be", ["bell.png"]),
        ("riot completion ", list(SHELLS)),
    ],
)
def test_bash_completes(line: str, words: list[str], bash: Callable[[str], list[str]]) -> None:
    assert bash(line) == words


@pytest.mark.parametrize("shell", SHELLS)
def test_the_script_of_each_shell_has_all_commands_and_is_well_formed(
    shell: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code, out, _ = ended(capsys, "completion", shell)
    assert code == 0
    for path in paths(RIOT):
        assert not path or f"{' '.join(path[:-1])}|c|{path[-1]}|" in out
    if shutil.which(shell) is None:
        pytest.skip(f"no {shell} here")
    (tmp_path / "script").write_text(out, encoding="utf-8")
    subprocess.run([shell, "-n", str(tmp_path / "script")], check=True, timeout=60)


def test_fish_completes(tmp_path: Path) -> None:
    if shutil.which("fish") is None:
        pytest.skip("no fish here")
    (tmp_path / "riot.fish").write_text(script(RIOT, "fish"), encoding="utf-8")
    for line, words in (
        ("riot cac", ["cache"]),
        ("riot make --met", ["--method"]),
        ("riot mine cluster=sl", ["slurm"]),
    ):
        command = ["fish", "-c", f"source {tmp_path / 'riot.fish'}; complete -C '{line}'"]
        done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60)
        assert done.stderr == ""
        assert [entry.partition("\t")[0].rpartition("=")[2] for entry in done.stdout.splitlines()] == words


BASE = """
import importlib.abc, sys
EXTRAS = {"hydra", "omegaconf", "dask", "distributed", "pyarrow", "rich", "jinja2", "pooch", "platformdirs", "uvicorn"}
class Absent(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in EXTRAS:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)
sys.meta_path.insert(0, Absent())
from pipeline.cli.main import main
sys.exit(main(sys.argv[1:]))
"""
"""A process that has the library alone, as without the extra for mining."""


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (("mine",), 2, "pip install 'riot-shapes[mine]'"),
        (("cache", "du"), 2, "pip install 'riot-shapes[mine]'"),
        (("studio",), 2, "pip install 'riot-shapes[studio]'"),
        (("show", "FILE"), 0, "certificate: passed"),
        (("slices", "--help"), 0, "--into"),
        (("completion", "bash"), 0, "make|o|--gif"),
    ],
    ids=lambda value: value[0] if isinstance(value, tuple) else None,
)
def test_the_library_alone_has_its_commands_and_names_the_extra_of_the_others(
    arguments: tuple[str, ...], code: int, words: str, transform: Path
) -> None:
    command = [sys.executable, "-c", BASE, *(str(transform) if word == "FILE" else word for word in arguments)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.returncode == code and words in done.stdout + done.stderr and "Traceback" not in done.stderr

"""What the guide shows works as it stands there, in the order of its pages; and the guide can be built."""

import contextlib
import re
import shlex

import pytest
from fenced import ROOT, blocks
from html_page import Page

import pipeline.cli.main
import pipeline.run
import pipeline.study.__main__ as study
from pipeline.config.command_line import check_command, complete
from pipeline.study.registry import STUDIES
from pipeline.tables.schemas import SCHEMAS

DOCS = ROOT / "docs"
PAGES = ("index.md", "howto/mine.md", "explanation/scores.md", "howto/tables.md", "tutorial/puzzle.md", "howto/studies.md", "explanation/findings.md", "explanation/limits.md")
COMMANDS = {
    ("riot",): (pipeline.cli.main.main, ()),
    ("python", "-m", "pipeline.run"): (pipeline.run.main, ("cluster=sync",)),  # which writes the same bytes
    ("python", "-m", "pipeline.study"): (study.main, ()),
}
"""How a command runs in this process, and what it is told besides."""


def run_line(line):
    words = shlex.split(line, comments=True)
    (known,) = [start for start in COMMANDS if tuple(words[: len(start)]) == start]
    main, more = COMMANDS[known]
    assert main([*words[len(known) :], *more]) == 0, line


@pytest.fixture(scope="module")
def reader(tmp_path_factory):
    """Runs the blocks of a page, once, after those of the pages before it, and returns the folder where all worked."""
    place, read = tmp_path_factory.mktemp("reader"), set()

    def run_up_to(page):
        for one in PAGES[: PAGES.index(page) + 1]:
            if one not in read:
                read.add(one)
                with contextlib.chdir(place):
                    run_blocks(one)
        return place

    return run_up_to


def run_blocks(page):
    names = {"__name__": "guide"}
    for block in blocks(DOCS / page):
        where = f"{page}:{block.line}"
        if block.language == "sh":
            for line in block.text.splitlines():
                run_line(line)
        else:
            assert block.language == "python", where
            exec(compile("\n" * block.line + block.text, where, "exec"), names)


@pytest.mark.parametrize("page", PAGES)
def test_every_block_of_the_guide_runs(page, reader):
    reader(page)


def test_what_the_guide_says_is_written_is_there(reader):
    place = reader("studies.md")
    run = place / "outputs" / "folder"
    for name in ("gallery/index.html", "report.html", "run.json", "qcrs", *(f"{name}.parquet" for name in SCHEMAS)):
        assert (run / name.replace("qcrs.parquet", "qcrs")).exists(), name
    assert list((run / "transforms").glob("*.riot"))
    assert list((place / "puzzle").rglob("*.stl")) and list((place / "puzzle").rglob("*.3mf"))
    assert (place / "puzzle" / "parts.json").is_file() and (place / "slices" / "set.json").is_file()
    assert {path.name for path in (run / "study").iterdir()} <= {*STUDIES, "index.html"}


def test_every_python_block_of_the_readme_runs(reader, tmp_path, monkeypatch):
    (tmp_path / "outputs").mkdir()
    (tmp_path / "outputs" / "mpeg7").symlink_to(reader("mine.md") / "outputs" / "folder")  # which has the same tables
    monkeypatch.chdir(tmp_path)
    names = {"__name__": "readme"}
    for block in blocks(ROOT / "README.md", "python"):
        exec(compile("\n" * block.line + block.text, f"README.md:{block.line}", "exec"), names)
    assert {"score", "i", "j"} == set(names["qcrs"].columns)


@pytest.mark.parametrize("path", ["README.md", "docs/howto/cluster.md"])
def test_runs_that_cannot_be_tried_here_have_known_parameters(path):
    lines = [line for block in blocks(ROOT / path, "sh") for line in block.text.splitlines()]
    told = [shlex.split(line, comments=True)[3:] for line in lines if line.startswith("python -m pipeline.run ")]
    assert len(told) >= 3
    for arguments in told:
        if "-m" not in arguments:  # of a sweep, each job is checked by itself
            check_command(complete(arguments))  # raises for names and values that there are not


def test_the_pages_are_all_of_the_guide():
    assert sorted(PAGES) == sorted(str(path.relative_to(DOCS)) for path in DOCS.rglob("*.md") if path.name != "cluster.md")  # needs machines
    listed = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    assert all(f": {name}\n" in listed for name in PAGES)


def test_parameters_that_the_guide_names_exist():
    known = {path.name for path in (ROOT / "conf").iterdir()}
    text = "\n".join((DOCS / page).read_text(encoding="utf-8") for page in PAGES)
    named = set(re.findall(r"`(\w+)\.(\w+)[=`]", text))
    checked = [(group, name) for group, name in named if group in known]
    assert len(checked) >= 5
    for group, name in checked:
        assert any(
            re.search(rf"^{name}:", file.read_text(), re.MULTILINE) for file in (ROOT / "conf" / group).iterdir()
        )


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    pytest.importorskip("mkdocs", reason="mkdocs is not installed (extra docs)")
    from mkdocs.commands.build import build
    from mkdocs.config import load_config

    folder = tmp_path_factory.mktemp("site")
    build(load_config(str(ROOT / "mkdocs.yml"), site_dir=str(folder)))
    return folder


def test_the_guide_can_be_built_and_needs_no_network(site):
    assert {path.name for path in site.glob("*.html")} >= {page.replace(".md", ".html") for page in PAGES}
    for page in PAGES:
        text = (site / page).with_suffix(".html").read_text(encoding="utf-8")
        assert not re.findall(r'<(?:script|link|img)[^>]+(?:src|href)="(?:https?:)?//', text)
    for name in ("strip.svg", "swing.svg", "figure.svg"):
        assert (site / "pictures" / name).read_text(encoding="utf-8").startswith("<svg")
    assert "<animateTransform" in (site / "pictures" / "swing.svg").read_text(encoding="utf-8")
    assert not list(site.rglob("hooks*"))


def test_the_built_guide_has_every_column_and_study(site):
    shown = "".join(Page((site / "tables.html").read_text(encoding="utf-8")).text)
    for name, schema in SCHEMAS.items():
        assert name in shown
        for field in schema:
            assert field.name in shown and field.metadata[b"meaning"].decode() in shown, field
    studies = "".join(Page((site / "studies.html").read_text(encoding="utf-8")).text)
    assert all(name in studies and study.meaning in studies for name, study in STUDIES.items())
    for page in (shown, studies):
        assert "<!--" not in page and "\\" not in page

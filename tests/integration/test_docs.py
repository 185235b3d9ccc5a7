"""What the guide shows works as it stands there, in the order of its pages; and the guide can be built."""

import contextlib
import importlib.util
import json
import re
import shlex

import pytest
from fenced import ROOT, blocks
from html_page import Page

import pipeline.cli.main
import pipeline.run
from pipeline.cli.main import RIOT
from pipeline.config.command_line import check_command, complete
from pipeline.config.conf_files import allowed_names, group_choices
from pipeline.study.registry import STUDIES
from pipeline.tables.schemas import SCHEMAS

DOCS = ROOT / "docs"


def load_notebook_page():
    """The module of the guide that runs its notebook."""
    spec = importlib.util.spec_from_file_location("notebook_page", DOCS / "notebook_page.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


TUTORIAL = ("index.md", "tutorial/two-pictures.md", "tutorial/collection.md", "tutorial/puzzle.md")
HOW_TO = tuple(
    f"howto/{name}.md" for name in ("mine", "tables", "match", "shape", "print", "slices", "sweeps", "studies")
)
PAGES = (*TUTORIAL, "explanation/scores.md", *HOW_TO)
"""Pages with blocks to run, each after those before it."""
COMMANDS = {
    ("riot",): (pipeline.cli.main.main, ()),
    ("riot", "mine"): (pipeline.run.main, ("cluster=sync",)),  # which writes the same bytes
}
"""How a command runs in this process, and arguments that only the test gives."""


def run_line(line):
    words = shlex.split(line, comments=True)
    known = max((start for start in COMMANDS if tuple(words[: len(start)]) == start), key=len)
    main, more = COMMANDS[known]
    assert main([*words[len(known) :], *more]) == 0, line


@pytest.fixture(scope="module")
def reader(tmp_path_factory):
    """Runs the blocks of a page, after those of the pages before it, each once; returns the folder they work in."""
    folder, read = tmp_path_factory.mktemp("reader"), set()

    def read_up_to(page):
        for earlier in PAGES[: PAGES.index(page) + 1]:
            if earlier not in read:
                read.add(earlier)
                with contextlib.chdir(folder):
                    run_blocks(earlier)
        return folder

    return read_up_to


def run_blocks(page):
    names = {"__name__": "guide"}
    for block in blocks(DOCS / page, "sh", "python"):
        if block.language == "sh":
            for line in block.text.splitlines():
                run_line(line)
        else:
            exec(compile("\n" * block.line + block.text, f"{page}:{block.line}", "exec"), names)


@pytest.mark.parametrize("page", TUTORIAL)
def test_every_block_of_the_tutorial_runs(page, reader):
    folder = reader(page)
    if page == "tutorial/collection.md":
        run = folder / "outputs" / "folder"
        for name in ("gallery/index.html", "report.html", "run.json", "qcrs", *(f"{name}.parquet" for name in SCHEMAS)):
            assert (run / name.replace("qcrs.parquet", "qcrs")).exists(), name
        assert list((run / "transforms").glob("*.riot"))
    if page == "tutorial/puzzle.md":
        assert list((folder / "puzzle").rglob("*.stl")) and list((folder / "puzzle").rglob("*.3mf"))
        assert (folder / "puzzle" / "parts.json").is_file()


@pytest.mark.system
@pytest.mark.parametrize("page", PAGES[len(TUTORIAL) :])
def test_every_block_of_the_other_pages_runs(page, reader):
    folder = reader(page)
    if page == "howto/slices.md":
        assert (folder / "slices" / "set.json").is_file()
    if page == "howto/studies.md":
        written = {path.name for path in (folder / "outputs" / "folder" / "study").iterdir()}
        assert written == {"distributions", "timing", "index.html"} and written <= {*STUDIES, "index.html"}


def test_pages_with_blocks_to_run_are_run_but_for_clusters():
    runnable = {str(path.relative_to(DOCS)) for path in DOCS.rglob("*.md") if blocks(path, "sh", "python")}
    assert runnable - {"howto/cluster.md"} == set(PAGES)


def test_every_page_is_listed_once():
    listed = re.findall(r": ([\w/-]+\.md)$", (ROOT / "mkdocs.yml").read_text(encoding="utf-8"), flags=re.MULTILINE)
    generated = ["contributing.md", "tutorial/notebook.md"]
    assert sorted(listed) == sorted([*generated, *(str(path.relative_to(DOCS)) for path in DOCS.rglob("*.md"))])


@pytest.mark.parametrize("path", ["README.md", *(f"docs/{page}" for page in (*PAGES, "howto/cluster.md"))])
def test_runs_have_known_parameters(path):
    lines = [line.strip() for block in blocks(ROOT / path, "sh") for line in re.split(r"\n|&&", block.text)]
    for line in lines:
        arguments = shlex.split(line, comments=True)
        for program in (["python", "-m", "pipeline.run"], ["riot", "mine"]):
            if arguments[: len(program)] == program:
                check_command(complete(arguments[len(program) :]))  # raises for names and values that there are not


def test_parameters_that_pages_name_exist():
    known = {*allowed_names(), *group_choices()}
    groups = {name.partition(".")[0] for name in known}
    named = {
        name
        for path in [ROOT / "README.md", *DOCS.rglob("*.md")]
        for name in re.findall(r"[`\s(]([a-z]+\.[a-z_]+)[=`]", path.read_text(encoding="utf-8"))
        if name.partition(".")[0] in groups
    }
    assert len(named) >= 10 and named <= known


def test_every_folder_that_the_architecture_names_exists():
    text = (DOCS / "explanation" / "architecture.md").read_text(encoding="utf-8")
    named = re.findall(r"`((?:riot|pipeline)/[\w/.]*)`", text)
    assert len(named) > 15
    assert [name for name in named if not (ROOT / name).exists()] == []


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    pytest.importorskip("mkdocstrings", reason="mkdocstrings is not installed (extra docs)")
    from mkdocs.commands.build import build
    from mkdocs.config import load_config

    folder = tmp_path_factory.mktemp("site")
    config = load_config(str(ROOT / "mkdocs.yml"), site_dir=str(folder))
    config.plugins.run_event("startup", command="build", dirty=False)
    build(config)
    return folder


@pytest.mark.system
def test_the_guide_can_be_built_and_needs_no_network(site):
    pages = {str(path.relative_to(DOCS).with_suffix(".html")) for path in DOCS.rglob("*.md")}
    assert {str(path.relative_to(site)) for path in site.rglob("*.html")} == {
        *pages,
        "404.html",
        "contributing.html",
        "tutorial/notebook.html",
    }
    for path in site.rglob("*.html"):
        loaded = re.findall(
            r'<(?:script|img)[^>]+src="(?:https?:)?//|<link[^>]+href="(?:https?:)?//', path.read_text(encoding="utf-8")
        )
        assert not loaded, path
    for name in ("strip.svg", "swing.svg", "figure.svg"):
        assert (site / "pictures" / name).read_text(encoding="utf-8").startswith("<svg")
    assert "<animateTransform" in (site / "pictures" / "swing.svg").read_text(encoding="utf-8")
    assert not list(site.rglob("hooks*")) + list(site.rglob("notebook_page*"))


@pytest.mark.system
def test_the_notebook_runs_and_shows_what_it_tells_of(tmp_path):
    pytest.importorskip("ipykernel")
    notebook = load_notebook_page().run_notebook(DOCS / "tutorial" / "notebook.ipynb", tmp_path)
    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    pages = [output.data["text/html"] for output in outputs if "text/html" in output.get("data", {})]
    assert len([page for page in pages if "<figure" in page]) >= 6
    assert len([page for page in pages if "<script>" in page]) >= 2  # transforms that swing
    assert len([page for page in pages if "<table" in page]) >= 6
    assert list((tmp_path / "puzzle").glob("*.stl")) and (tmp_path / "outputs" / "sample" / "run.json").is_file()


def test_the_notebook_is_kept_without_outputs():
    notebook = json.loads((DOCS / "tutorial" / "notebook.ipynb").read_text(encoding="utf-8"))
    code = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    assert len(code) > 10
    assert all(cell["outputs"] == [] and cell["execution_count"] is None for cell in code)


def shown_in(site, page):
    return "".join(Page((site / page).read_text(encoding="utf-8")).text)


@pytest.mark.system
def test_the_built_reference_is_complete(site):
    tables = shown_in(site, "reference/tables.html")
    for name, schema in SCHEMAS.items():
        assert name in tables
        for field in schema:
            assert field.name in tables and field.metadata[b"meaning"].decode() in tables, field
    parameters = shown_in(site, "reference/parameters.html")
    assert [name for name in allowed_names() if name not in parameters] == []
    studies = shown_in(site, "howto/studies.html")
    assert all(name in studies and meaning in studies for name, meaning in STUDIES.items())
    commands = shown_in(site, "reference/commands.html")
    assert all(f"riot {name}" in commands for name in RIOT.commands)
    for text in (tables, parameters, studies, commands):
        assert "<!--" not in text

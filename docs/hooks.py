"""What the guide shows that nobody types: pictures, commands, parameters, columns of tables, studies, folders."""

from __future__ import annotations

import ast
import contextlib
import dataclasses
import io
import os
import re
import tempfile
import tomllib
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from notebook_page import notebook_page

import pipeline.tables.measures
from pipeline import study
from pipeline.cli.main import RIOT
from pipeline.config.parameter_table import markdown_cell, parameter_table
from pipeline.study.registry import STUDIES
from pipeline.tables.schemas import SCHEMAS, SWEEP
from riot import Shape, construct
from riot.cli.command import Command, Group
from riot.cli.parser import listing
from riot.cli.program import group_help
from riot.draw import animate_svg, draw_strip

ROOT = Path(__file__).resolve().parents[1]
HELP_WIDTH = 80
STUDIO = ROOT / "build" / "studio"
"""Pictures of the studio's steps, which its tests in a browser leave there (`make docs`)."""
NOTEBOOK = "tutorial/notebook"
"""Of the guide: a page without suffix, in the repository without outputs."""


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pictures, which pages name as ``pictures/…``, the notebook as a page, and the page for contributors."""
    for name, text in _pictures():
        files.append(File.generated(config, f"pictures/{name}", content=text))
    for picture in _studio_pictures():
        files.append(File.generated(config, f"pictures/{picture.name}", content=picture.read_bytes()))
    files.append(File.generated(config, f"{NOTEBOOK}.md", content=notebook_page(ROOT / "docs" / f"{NOTEBOOK}.ipynb")))
    contributing = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8").replace("](docs/", "](")
    files.append(File.generated(config, "contributing.md", content=contributing))
    return files


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Replace each ``<!-- name -->`` of a generated text by the text."""
    for name, lines in GENERATED.items():
        marker = f"<!-- {name} -->"
        if marker in markdown:
            markdown = markdown.replace(marker, "\n".join(lines()))
    return markdown.replace(f"{NOTEBOOK}.ipynb)", f"{NOTEBOOK}.md)")


def _pictures() -> Iterator[tuple[str, str]]:
    house = Shape.from_polygon([(0, 0), (4, 0), (4, 3), (2, 5), (0, 3)], name="house")
    kite = Shape.from_polygon([(0, 3), (-2, 0), (0, -2), (2, 0)], name="kite")
    transform = construct(house, kite)
    yield "swing.svg", animate_svg(transform)
    with tempfile.TemporaryDirectory() as folder:
        for name, draw in (("figure.svg", transform.draw), ("strip.svg", lambda path: draw_strip(transform, path))):
            path = Path(folder, name)
            draw(path)
            yield name, path.read_text(encoding="utf-8")


def _studio_pictures() -> list[Path]:
    return sorted(STUDIO.glob("*-desktop-light.png"))


def _studio_picture(step: str) -> Iterator[str]:
    """The picture of a step, if there is a browser on this machine that made it."""
    if (STUDIO / f"{step}-desktop-light.png").exists():
        yield f"![The step {step.capitalize()} of the studio](../pictures/{step}-desktop-light.png)"


def _commands() -> Iterator[str]:
    """What each command prints for ``--help``; parameters of a run and of studies have pages of their own."""
    columns = os.environ.get("COLUMNS")
    os.environ["COLUMNS"] = str(HELP_WIDTH)
    try:
        yield from _listed("riot", RIOT)
        yield from ("## python -m pipeline.tables.measures", "", "```text", _measures_help().rstrip(), "```", "")
    finally:
        os.environ.pop("COLUMNS") if columns is None else os.environ.update(COLUMNS=columns)


def _measures_help() -> str:
    text = io.StringIO()
    with contextlib.redirect_stdout(text), contextlib.suppress(SystemExit):
        pipeline.tables.measures.main(["--help"])
    return text.getvalue()


def _listed(program: str, entry: Group | Command) -> Iterator[str]:
    if isinstance(entry, Group):
        yield from (f"## {program}", "", "```text", group_help(program, entry), "```", "")
        if program != "riot study":
            for name, below in entry.commands.items():
                yield from _listed(f"{program} {name}", below)
    else:
        parser = entry.parser(program)
        text = "\n".join([parser.options_help(), listing("exit codes", parser.exit_codes)])
        yield from (f"## {program}", "", "```text", text.rstrip(), "```", "")


def _parameters() -> Iterator[str]:
    yield parameter_table()


def _tables() -> Iterator[str]:
    for name, schema in {**SCHEMAS, "sweep": SWEEP}.items():
        yield f"## {name}\n\n{markdown_cell(schema.metadata[b'meaning'].decode())}\n"
        yield "| column | type | unit | meaning |\n|---|---|---|---|"
        for field in schema:
            unit, meaning = (field.metadata[key].decode() for key in (b"unit", b"meaning"))
            cells = (str(field.type), unit, meaning)
            yield f"| `{field.name}` | {' | '.join(map(markdown_cell, cells))} |"
        yield ""


def _studies() -> Iterator[str]:
    yield "| study | asks | parameters |\n|---|---|---|"
    for name, meaning in STUDIES.items():
        defaults = ", ".join(
            f"`{field.name}={field.default}`" for field in dataclasses.fields(getattr(study, name).Parameters)
        )
        yield f"| `{name}` | {markdown_cell(meaning)} | {defaults or 'none'} |"


def _layers() -> Iterator[str]:
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    for contract in settings["tool"]["importlinter"]["contracts"]:
        if contract["type"] == "layers":
            lines = (", ".join(re.split(r" [|:] ", layer)) for layer in contract["layers"])
            yield from ("```text", *(f"{package}/" for package in contract["containers"]))
            yield from (*(f"    {line}" for line in lines), "```", "")


def _folders() -> Iterator[str]:
    for face in sorted(path for package in ("riot", "pipeline") for path in (ROOT / package).rglob("__init__.py")):
        meaning = (ast.get_docstring(ast.parse(face.read_text(encoding="utf-8"))) or "").split("\n\n")[0]
        if meaning:
            text = markdown_cell(" ".join(meaning.split()).replace("`", ""))
            yield f"| `{face.parent.relative_to(ROOT)}/` | {text} |"


GENERATED: dict[str, Callable[[], Iterator[str]]] = {
    "commands": _commands,
    "parameters": _parameters,
    "tables": _tables,
    "studies": _studies,
    "folders": _folders,
    "layers": _layers,
} | {f"studio {step}": partial(_studio_picture, step) for step in ("start", "look", "choose", "edit", "make")}
"""Each text that pages may ask for, by the name in its marker."""

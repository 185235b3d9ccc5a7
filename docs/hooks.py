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
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

import pipeline.cli.cache
import pipeline.cli.main
import pipeline.datasets.fetch
import pipeline.tables.measures
from pipeline import study
from pipeline.config.help import usage_text
from pipeline.config.parameter_table import markdown_cell, parameter_table
from pipeline.study.registry import STUDIES
from pipeline.tables.schemas import SCHEMAS, SWEEP
from riot import Shape, construct
from riot.draw import animate_svg, draw_strip

ROOT = Path(__file__).resolve().parents[1]
HELP_WIDTH = 80

Main = Callable[[Sequence[str]], int]
COMMANDS: dict[str, Main] = {
    "riot": pipeline.cli.main.main,
    "python -m pipeline.cache": pipeline.cli.cache.main,
    "python -m pipeline.fetch": pipeline.datasets.fetch.main,
    "python -m pipeline.tables.measures": pipeline.tables.measures.main,
}
"""Commands that print their options for ``--help``, and the function that runs each."""


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pictures, which pages name as ``pictures/…``, and the page for contributors."""
    for name, text in _pictures():
        files.append(File.generated(config, f"pictures/{name}", content=text))
    contributing = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8").replace("](docs/", "](")
    files.append(File.generated(config, "contributing.md", content=contributing))
    return files


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Replace each ``<!-- name -->`` of a generated text by the text."""
    for name, lines in GENERATED.items():
        marker = f"<!-- {name} -->"
        if marker in markdown:
            markdown = markdown.replace(marker, "\n".join(lines()))
    return markdown


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


def _commands() -> Iterator[str]:
    for command, main in COMMANDS.items():
        text = _help(main)
        yield from (f"## {command}", "")
        names = re.findall(r"^    (\w+) ", text, flags=re.MULTILINE)
        if not names:
            yield from _listing(text, command)
        for name in names:
            yield from (f"### {command.rpartition(' ')[2]} {name}", "")
            yield from _listing(_help(main, name), command)
    yield from ("## python -m pipeline.run", "", *_listing(usage_text(), "python -m pipeline.run"))
    yield from ("## python -m pipeline.study", "", *_docstring("pipeline/study/__main__.py"))


def _help(main: Main, *arguments: str) -> str:
    """What a command prints for ``--help``, at one width on every machine."""
    text = io.StringIO()
    columns = os.environ.get("COLUMNS")
    os.environ["COLUMNS"] = str(HELP_WIDTH)
    try:
        with contextlib.redirect_stdout(text), contextlib.suppress(SystemExit):
            main([*arguments, "--help"])
    finally:
        if columns is None:
            del os.environ["COLUMNS"]
        else:
            os.environ["COLUMNS"] = columns
    return text.getvalue()


def _listing(text: str, command: str) -> Iterator[str]:
    # argparse may name the program by the process that runs, here mkdocs.
    yield from ("```text", re.sub(r"^usage: .*?(?=riot|python -m|\[|-)", "usage: ", text.strip(), count=1), "```", "")


def _docstring(module: str) -> Iterator[str]:
    text = ast.get_docstring(ast.parse((ROOT / module).read_text(encoding="utf-8"))) or ""
    yield from (text.replace("``", "`").removeprefix("Entry point: "), "")


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
}
"""Each text that pages may ask for, by the name in its marker."""

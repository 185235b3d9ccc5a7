"""What the guide shows that nobody types: pictures, commands, parameters, columns of tables, studies, folders."""

from __future__ import annotations

import ast
import contextlib
import dataclasses
import html
import inspect
import io
import itertools
import os
import re
import tempfile
import tomllib
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, get_type_hints

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

import pipeline.cli.cache
import pipeline.cli.main
import pipeline.datasets.fetch
import pipeline.tables.measures
from pipeline import study
from pipeline.config.conf_files import group_choices
from pipeline.config.schema import Config
from pipeline.study.registry import STUDIES
from pipeline.tables.schemas import SCHEMAS, SWEEP
from riot import Shape, construct
from riot.draw import animate_svg, draw_strip
from riot.parameters.field import describe

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
    yield from ("## python -m pipeline.run", "", *_docstring("pipeline/run.py"))
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
    kinds = get_type_hints(Config)
    yield from ("## The run", "", *_parameter_table(Config, "", dict.fromkeys(_groups(kinds))), "")
    for group in _groups(kinds):
        yield from (f"## {group}", "", " ".join((inspect.getdoc(kinds[group]) or "").replace("``", "`").split()), "")
        choices = group_choices().get(group, [])
        if len(choices) > 1:
            yield from ("Choices: " + ", ".join(f"`{group}={choice}`" for choice in choices) + ".", "")
        yield from (*_parameter_table(kinds[group], f"{group}.", {}), "")


def _groups(kinds: dict[str, Any]) -> list[str]:
    return [name for name, kind in kinds.items() if dataclasses.is_dataclass(kind)]


def _parameter_table(kind: Any, prefix: str, without: dict[str, None]) -> Iterator[str]:
    yield "| parameter | type | default | unit | range | meaning |\n|---|---|---|---|---|---|"
    meanings = _field_docstrings(kind)
    for field in dataclasses.fields(kind):
        if field.name not in without:
            default = "needed" if field.default is dataclasses.MISSING else field.default
            declared = describe(field)
            meaning, unit, allowed = meanings.get(field.name, ""), "", ""
            if declared is not None:
                meaning, unit, allowed = f"{declared.meaning} Source: {declared.source}.", declared.unit, declared.range
            cells = (str(field.type), "null" if default is None else str(default), unit, allowed, meaning)
            yield f"| `{prefix}{field.name}` | {' | '.join(_cell(cell) for cell in cells)} |"


def _field_docstrings(kind: type) -> dict[str, str]:
    """The docstring below each field of a dataclass and its bases."""
    meanings: dict[str, str] = {}
    for base in reversed(kind.__mro__[:-1]):
        (definition,) = ast.parse(inspect.getsource(base)).body
        assert isinstance(definition, ast.ClassDef)
        for field, below in itertools.pairwise(definition.body):
            if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name) and isinstance(below, ast.Expr):
                meanings[field.target.id] = " ".join(str(ast.literal_eval(below.value)).replace("``", "").split())
    return meanings


def _tables() -> Iterator[str]:
    for name, schema in {**SCHEMAS, "sweep": SWEEP}.items():
        yield f"## {name}\n\n{_cell(schema.metadata[b'meaning'].decode())}\n"
        yield "| column | type | unit | meaning |\n|---|---|---|---|"
        for field in schema:
            unit, meaning = (field.metadata[key].decode() for key in (b"unit", b"meaning"))
            yield f"| `{field.name}` | {_cell(str(field.type))} | {_cell(unit)} | {_cell(meaning)} |"
        yield ""


def _studies() -> Iterator[str]:
    yield "| study | asks | parameters |\n|---|---|---|"
    for name, meaning in STUDIES.items():
        defaults = ", ".join(
            f"`{field.name}={field.default}`" for field in dataclasses.fields(getattr(study, name).Parameters)
        )
        yield f"| `{name}` | {_cell(meaning)} | {defaults or 'none'} |"


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
            yield f"| `{face.parent.relative_to(ROOT)}/` | {_cell(' '.join(meaning.split()).replace('`', ''))} |"


def _cell(text: str) -> str:
    """Text as it stands in a cell of a Markdown table."""
    return html.escape(text, quote=False).translate({ord(mark): f"&#{ord(mark)};" for mark in "|*_[`\\"})


GENERATED: dict[str, Callable[[], Iterator[str]]] = {
    "commands": _commands,
    "parameters": _parameters,
    "tables": _tables,
    "studies": _studies,
    "folders": _folders,
    "layers": _layers,
}
"""Each text that pages may ask for, by the name in its marker."""

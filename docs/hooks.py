"""What the guide shows that is not typed by hand: pictures drawn by the code, columns of the tables, studies."""

from __future__ import annotations

import dataclasses
import html
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

from pipeline.study.registry import STUDIES
from pipeline.tables.schemas import SCHEMAS, SWEEP
from riot import Shape, construct
from riot.draw.animate import animate_svg
from riot.draw.strip import draw_strip


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pictures; the pages name them as ``pictures/…``."""
    for name, text in _pictures():
        files.append(File.generated(config, f"pictures/{name}", content=text))
    return files


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Put generated tables in the places of ``<!-- tables -->`` and ``<!-- studies -->``."""
    filled = markdown.replace("<!-- tables -->", "\n".join(_tables()))
    return filled.replace("<!-- studies -->", "\n".join(_studies()))


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


def _tables() -> Iterator[str]:
    for name, schema in {**SCHEMAS, "sweep": SWEEP}.items():
        yield f"### {name}\n\n{_cell(schema.metadata[b'meaning'].decode())}\n"
        yield "| column | type | unit | meaning |\n|---|---|---|---|"
        for field in schema:
            unit, meaning = (field.metadata[key].decode() for key in (b"unit", b"meaning"))
            yield f"| `{field.name}` | {_cell(str(field.type))} | {_cell(unit)} | {_cell(meaning)} |"
        yield ""


def _studies() -> Iterator[str]:
    for name, study in STUDIES.items():
        defaults = ", ".join(f"`{one.name}={one.default}`" for one in dataclasses.fields(study.parameters))
        yield f"| `{name}` | {_cell(study.meaning)} | {defaults or 'none'} |"


def _cell(text: str) -> str:
    """Text as it stands in a cell of a Markdown table."""
    return html.escape(text, quote=False).translate({ord(mark): f"&#{ord(mark)};" for mark in "|*_[`\\"})

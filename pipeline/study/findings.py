"""What a study found, and how it is written: a table with units, figures, and a page. Ours."""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import matplotlib as mpl
import pyarrow as pa
import pyarrow.parquet as pq
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from pipeline.report.markup import document, section, table
from pipeline.report.style import style_sheet
from pipeline.store.store import write_atomically
from pipeline.study.names import LEAD, PAGE, TABLE
from pipeline.tables.schemas import schema
from riot.draw.svg import escape

DOTS_PER_INCH = 160

WIDE = 3.0
"""Figures that are so many times wider than high fill the page's width."""


@dataclass(frozen=True)
class Sheet:
    """A small table of the page: plain text in the cells, numbers flush right from column ``numeric`` on."""

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    numeric: int = 1


@dataclass(frozen=True, eq=False)
class Findings:
    """A study's outcome: a sentence or two, the table of all its values, and what the page shows.

    ``figures`` are by file name without suffix, each with its caption; ``files`` by name, to lie beside the page.
    """

    title: str
    lead: str
    table: pa.Table
    sheets: Sequence[Sheet] = ()
    figures: Mapping[str, tuple[Figure, str]] = field(default_factory=dict)
    files: Mapping[str, bytes] = field(default_factory=dict)


def of_columns(meaning: str, columns: Sequence[tuple[pa.Field, Any]]) -> pa.Table:
    """A table of columns and their values."""
    typed = schema(meaning, *(one for one, _ in columns))
    return pa.table([pa.array(values, one.type) for one, values in columns], schema=typed)


def encoded(table: pa.Table) -> bytes:
    """A table as a Parquet file."""
    stream = io.BytesIO()
    pq.write_table(table, stream)
    return stream.getvalue()


def write_findings(found: Findings, folder: Path) -> Path:
    """Write the table, every figure as PNG and SVG, the other files, and the page, whose path is returned.

    The same findings give the same bytes.
    """
    folder.mkdir(parents=True, exist_ok=True)
    said = {**(found.table.schema.metadata or {}), LEAD: found.lead.encode()}
    write_atomically(folder / TABLE, encoded(found.table.replace_schema_metadata(said)))
    for name, content in found.files.items():
        write_atomically(folder / name, content)
    shown = []
    for name, (figure, caption) in found.figures.items():
        drawn = svg(figure, name)
        write_atomically(folder / f"{name}.svg", drawn)
        write_atomically(folder / f"{name}.png", png(figure))
        width, height = figure.get_size_inches()
        shown.append(_picture(drawn, caption, width > WIDE * height))
    write_atomically(folder / PAGE, _page(found, shown).encode())
    return folder / PAGE


def png(figure: Figure) -> bytes:
    """A figure as PNG, without a date."""
    stream = io.BytesIO()
    FigureCanvasAgg(figure).print_figure(stream, format="png", dpi=DOTS_PER_INCH, metadata={"Software": None})
    return stream.getvalue()


def svg(figure: Figure, name: str) -> bytes:
    """A figure as SVG, without a date, the ids in it made of ``name``."""
    stream = io.BytesIO()
    with mpl.rc_context({"svg.hashsalt": name, "svg.fonttype": "none"}):
        FigureCanvasSVG(figure).print_figure(stream, format="svg", metadata={"Date": None, "Creator": None})
    return stream.getvalue()


def _picture(drawn: bytes, caption: str, wide: bool) -> str:
    # As an image of its own, the ids of one figure do not meet those of another.
    data = base64.b64encode(drawn).decode()
    said, style, kind = escape(caption), "display:block;width:100%", "plot wide" if wide else "plot"
    return (
        f'<figure class="{kind}"><img alt="{said}" style="{style}" src="data:image/svg+xml;base64,{data}">'
        f"<figcaption>{said}</figcaption></figure>"
    )


def _page(found: Findings, pictures: Sequence[str]) -> str:
    sections = [
        section(
            f"s{number}",
            sheet.title,
            '<div class="sheet">'
            + table(
                [escape(name) for name in sheet.head],
                [[escape(cell) for cell in row] for row in sheet.rows],
                [place >= sheet.numeric for place in range(len(sheet.head))],
                sheet.title,
            )
            + "</div>",
        )
        for number, sheet in enumerate(found.sheets)
    ]
    if pictures:
        sections.append(section("figures", "Figures", f'<div class="plots">{"".join(pictures)}</div>'))
    body = (
        f'<header class="top"><p class="kicker"><a href="../index.html">Studies</a></p><h1>{escape(found.title)}</h1>'
        f'<p class="lead">{escape(found.lead)}</p></header>\n<main>\n{"".join(sections)}</main>\n'
        f"<footer>Every value is in {TABLE} beside this page.</footer>\n"
    )
    return document(found.title, f"<style>{style_sheet()}</style>", body)

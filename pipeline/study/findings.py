"""The findings of a study, and how they are written: a table with units, figures, and a page. Ours."""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from pipeline.report.environment import render
from pipeline.store.store import write_atomically
from pipeline.study.registry import LEAD, PAGE, TABLE
from pipeline.tables.schemas import schema
from riot.errors import needs_extra

with needs_extra("mine"):
    import pyarrow as pa
    import pyarrow.parquet as pq

DOTS_PER_INCH = 160
"""Resolution of PNG figures (ours: sharp at the page's width on a dense screen)."""

WIDE = 3.0
"""Figures whose width is more than this multiple of their height fill the page's width (ours)."""


@dataclass(frozen=True)
class Sheet:
    """A small table of the page: plain text in the cells, numbers flush right from column ``numeric`` on."""

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    numeric: int = 1

    @property
    def columns(self) -> tuple[tuple[str, bool], ...]:
        """The head of each column, and whether numbers stand below it."""
        return tuple((name, index >= self.numeric) for index, name in enumerate(self.head))


@dataclass(frozen=True)
class FigureImage:
    """A figure of the page: an SVG file in base64; a wide one fills the page's width."""

    data: str
    caption: str
    wide: bool


@dataclass(frozen=True, eq=False)
class Findings:
    """The results of a study: a lead of a sentence or two, the table of all values, and what the page shows.

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
    typed = schema(meaning, *(field_ for field_, _ in columns))
    return pa.table([pa.array(values, field_.type) for field_, values in columns], schema=typed)


def encoded(table: pa.Table) -> bytes:
    """A table as a Parquet file."""
    stream = io.BytesIO()
    pq.write_table(table, stream)
    return stream.getvalue()


def write_findings(findings: Findings, folder: Path) -> Path:
    """Write the table, every figure as PNG and SVG, the other files, and the page, whose path is returned.

    The same findings give the same bytes.
    """
    folder.mkdir(parents=True, exist_ok=True)
    metadata = {**(findings.table.schema.metadata or {}), LEAD: findings.lead.encode()}
    write_atomically(folder / TABLE, encoded(findings.table.replace_schema_metadata(metadata)))
    for name, content in findings.files.items():
        write_atomically(folder / name, content)
    pictures = []
    for name, (figure, caption) in findings.figures.items():
        drawn = svg(figure, name)
        write_atomically(folder / f"{name}.svg", drawn)
        write_atomically(folder / f"{name}.png", png(figure))
        width, height = figure.get_size_inches()
        # Each figure is an image of its own, so that ids in two of them do not clash.
        pictures.append(FigureImage(base64.b64encode(drawn).decode(), caption, width > WIDE * height))
    page = render("study.html", findings=findings, pictures=pictures, table=TABLE)
    write_atomically(folder / PAGE, page.encode())
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

"""The page of a run's studies: what each asks, what it found if it was made, else the command that makes it. Ours."""

from __future__ import annotations

from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from pipeline.report.markup import document
from pipeline.report.style import style_sheet
from pipeline.store.store import write_atomically
from pipeline.study.names import LEAD, MEANINGS, PAGE, TABLE
from pipeline.tables.record import STUDY
from riot.draw.svg import escape

INDEX = "index.html"


def write_contents(run_dir: Path) -> Path:
    """Write ``study/index.html`` of a finished run, from the tables of the studies that are there; returns its path.

    The same studies give the same bytes.
    """
    folder = run_dir / STUDY
    folder.mkdir(exist_ok=True)
    entries = "".join(_entry(folder, name, meaning) for name, meaning in MEANINGS.items())
    body = (
        f'<header class="top"><p class="kicker"><a href="../report.html">{escape(run_dir.name)}</a></p>'
        "<h1>Studies</h1><p class=\"lead\">What the run's tables tell of the scores. A study takes the run's own "
        f"arguments and writes a table, figures and a page.</p></header>\n<main>\n{entries}</main>\n"
    )
    head = f"<style>{style_sheet()}</style>"
    write_atomically(folder / INDEX, document(f"{run_dir.name} · studies", head, body).encode())
    return folder / INDEX


def _entry(folder: Path, name: str, meaning: str) -> str:
    lead = _lead(folder / name / TABLE)
    if lead is None:
        found = f'<p class="note"><code>python -m pipeline.study {name}</code></p>'
    else:
        found = f'<p>{escape(lead)}</p><p><a href="{name}/{PAGE}">Tables and figures</a></p>'
    return f'<section id="{name}"><h2>{escape(name)}</h2><p class="note">{escape(meaning)}</p>{found}</section>\n'


def _lead(table: Path) -> str | None:
    """The findings in a sentence or two, as the table has them; None without a table that can be read."""
    try:
        metadata = pq.read_schema(table).metadata or {}
    except (OSError, pa.ArrowException):
        return None
    return metadata[LEAD].decode() if LEAD in metadata else None

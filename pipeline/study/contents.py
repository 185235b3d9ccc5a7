"""The page that lists a run's studies: their questions, their findings, or the command that makes them. Ours."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from pipeline.report.environment import render
from pipeline.store.store import write_atomically
from pipeline.study.registry import LEAD, PAGE, STUDIES, TABLE
from pipeline.tables.record import STUDY
from riot.errors import needs_extra

with needs_extra("mine"):
    import pyarrow as pa
    import pyarrow.parquet as pq

INDEX = "index.html"


@dataclass(frozen=True)
class StudySummary:
    """A study on the page; ``lead`` are its findings in a sentence or two, None unless it was made."""

    name: str
    meaning: str
    lead: str | None
    page: str


def write_contents(run_dir: Path) -> Path:
    """Write ``study/index.html`` of a finished run, from the tables of the studies that are there; returns its path.

    The same studies give the same bytes.
    """
    folder = run_dir / STUDY
    folder.mkdir(exist_ok=True)
    studies = [
        StudySummary(name, meaning, _lead(folder / name / TABLE), f"{name}/{PAGE}") for name, meaning in STUDIES.items()
    ]
    write_atomically(folder / INDEX, render("studies.html", run=run_dir.name, studies=studies).encode())
    return folder / INDEX


def _lead(table: Path) -> str | None:
    """The findings as the table has them; None without a table that can be read."""
    try:
        metadata = pq.read_schema(table).metadata or {}
    except (OSError, pa.ArrowException):
        return None
    return metadata[LEAD].decode() if LEAD in metadata else None

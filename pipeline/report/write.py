"""Read a run, draw its transforms, and put the page beside the tables."""

from __future__ import annotations

from pathlib import Path

from pipeline.report.card import Card, card
from pipeline.report.page import page
from pipeline.report.rows import TransformRow, read_run
from pipeline.skins import read_skins
from pipeline.store import write_atomically
from riot.errors import FormatError
from riot.riotfile import from_json

REPORT = "report.html"


def write_report(run_dir: Path) -> Path:
    """Write ``report.html`` into the folder of a finished run and return its path.

    The page depends on the run's tables, `run.json` and transforms alone: the same ones give the same bytes. A
    transform whose file is gone or damaged is listed as such instead of stopping the report. Raises
    `pipeline.report.rows.ReportError` (a FileNotFoundError) if a table is missing. Ours.
    """
    run = read_run(run_dir)
    cards: list[Card] = []
    lost: list[tuple[TransformRow, str]] = []
    for row in run.made:
        try:
            text = (run_dir / row.file).read_text(encoding="utf-8", errors="replace")
            transform = from_json(text, row.file)
            cards.append(card(row, transform, read_skins(run_dir, row.file, len(transform))))
        except FileNotFoundError:
            lost.append((row, f"{row.file} is gone; run again to restore it"))
        except FormatError as error:
            lost.append((row, str(error)))
    target = run_dir / REPORT
    write_atomically(target, page(run, cards, lost).encode())
    return target

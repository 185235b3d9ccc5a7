"""Write the tables of a run from the store, batch by batch, so that equal runs give equal bytes."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from pipeline.tables.outputs import from_rows, write_table
from pipeline.tables.pair_tables import crs_rows, selected_rows, write_qcrs
from pipeline.tables.puzzles import write_puzzles
from pipeline.tables.results import Results, Row
from pipeline.tables.schemas import SCHEMAS
from pipeline.tables.shape_tables import near_duplicate_rows, own_tables, shape_rows, stage_rows
from pipeline.tables.textures import write_textures
from pipeline.tables.transforms import transform_rows, write_transforms


def write_tables(results: Results, folder: Path) -> list[Path]:
    """Write every table and the transforms' files into ``folder``; returns the files, sorted.

    Each table is written under a temporary name and then renamed; it replaces the table of an earlier run.
    """
    folder.mkdir(parents=True, exist_ok=True)
    transforms = transform_rows(results)
    rows = {
        "near_duplicates": near_duplicate_rows(results),
        "selected": selected_rows(results),
        "crs": crs_rows(results),
        "errors": results.errors,
        "timings": _timings(results),
    }
    written = [
        write_table(folder, "shapes", shape_rows(results)),
        *(write_table(folder, name, stage_rows(results, name)) for name in own_tables()),
        *write_qcrs(results, folder),
        *(write_table(folder, name, [from_rows(SCHEMAS[name], of_table)]) for name, of_table in rows.items()),
        *write_transforms(transforms, folder),
        *write_textures(results, transforms, folder),
        *write_puzzles(results, transforms, folder),
    ]
    return sorted(written)


def _timings(results: Results) -> Iterator[Row]:
    names = set(SCHEMAS["timings"].names) - {"stage", "items"}
    for ended in results.stages:
        yield {"stage": ended.stage, "items": ended.total} | {name: getattr(ended, name) for name in names}

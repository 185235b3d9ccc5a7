"""Write the puzzles of a run: a folder of files for each, and the table `fabrications`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from pipeline.store.store import write_atomically
from pipeline.tables import schemas as tables
from pipeline.tables.outputs import from_rows, new_place, replace_folder, write_table
from pipeline.tables.results import Results, Row

FOLDER = "print"

SHARED = ("rank", "i", "j", "name_i", "name_j", "class_i", "class_j")
"""Columns that a puzzle's row copies from its transform's row."""


def write_puzzles(results: Results, transforms: Sequence[Row], folder: Path) -> list[Path]:
    """Write ``print/<pair>/…`` and the table `fabrications` into ``folder``; returns the files.

    ``transforms`` are the rows of the table of that name, with rank and file; a puzzle's folder has the name of its
    transform's file.
    Puzzles of an earlier run are replaced.
    """
    temporary = new_place(folder)
    temporary.mkdir()
    of_pair = {(row["i"], row["j"]): row for row in transforms}
    rows, files = [], []
    for item in results.work.get("fabricate", ()):
        artifact = results.artifact(item)
        if artifact is None or "status" not in artifact.document:
            continue
        p, q = (int(results.numbers[position]) for position in item.members)
        transform = of_pair[p, q]
        puzzle_folder = f"{FOLDER}/{Path(transform['file']).stem}" if artifact.arrays else ""
        for name, data in artifact.arrays.items():
            target = temporary / Path(puzzle_folder).name / name
            target.parent.mkdir(parents=True, exist_ok=True)
            write_atomically(target, data.tobytes())
            files.append(folder / puzzle_folder / name)
        rows.append(_row(transform, artifact.document, puzzle_folder))
    replace_folder(temporary, folder / FOLDER)
    rows.sort(key=lambda row: int(row["rank"]))
    return [write_table(folder, "fabrications", [from_rows(tables.SCHEMAS["fabrications"], rows)]), *files]


def _row(transform: Row, document: Mapping[str, object], puzzle_folder: str) -> Row:
    columns = [name for name in tables.SCHEMAS["fabrications"].names if name not in (*SHARED, "folder")]
    return {
        **{name: transform[name] for name in SHARED},
        **{name: document.get(name) for name in columns},
        "folder": puzzle_folder,
    }

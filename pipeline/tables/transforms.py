"""The table of transforms, and their ``.riot`` files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from pipeline.stages.choose import chosen
from pipeline.store.store import write_atomically
from pipeline.tables.history import pair_history, with_history
from pipeline.tables.outputs import file_name, from_rows, new_place, replace_folder, write_table
from pipeline.tables.pair_tables import items_of_pairs, pair_names, stage_values
from pipeline.tables.results import Results, Row
from pipeline.tables.schemas import SCHEMAS

FOLDER = "transforms"

STATUSES = ("certified", "approximate", "rejected")
"""In the order of the table."""


def transform_rows(results: Results) -> list[Row]:
    """Rows of `transforms`, ranked; ``riot`` is the text of the transform's file, None without one.

    Where the run chose among what it constructed, the chosen come first, in order of the choice.
    """
    rows = []
    items = items_of_pairs(results, "transforms")
    ranks = {item.members: rank for rank, item in enumerate(chosen(results.progress))}
    selected = {item.members: rank for rank, item in enumerate(results.progress.work["crs"], start=1)}
    for item in results.progress.work["construct"]:
        constructed = results.artifact(item)
        if constructed is None or constructed.document["status"] == "failed":
            continue
        of_pair, rank = items[item.members], selected[item.members]
        planned = results.artifact(of_pair.get("motion"))
        text = (planned.document if planned is not None else {}).get("riot", constructed.document.get("riot"))
        rows.append(
            {
                "chosen": item.members in ranks,
                "selected": rank,
                "pair": item.members,
                **pair_names(results, item.members),
                "qcrs": float(results.qcrs[rank - 1]),
                **stage_values(results, "transforms", item.members, of_pair),
                "riot": with_history(text, pair_history(results, item.members)),
            }
        )
    rows.sort(key=_least_deformed_first)
    if "choose" in results.progress.work:
        rows.sort(key=lambda row: ranks.get(row["pair"], len(ranks)))
    for rank, row in enumerate(rows, start=1):
        name = f"{rank:04d}_{file_name(row['name_i'])}_{file_name(row['name_j'])}.riot"
        row |= {"rank": rank, "file": "" if row["riot"] is None else f"{FOLDER}/{name}"}
    return rows


def _least_deformed_first(row: Row) -> tuple[int, float, int]:
    group = STATUSES.index(row["status"])
    return (group, -row["iou"] if group < 2 else 0.0, row["selected"])


def write_transforms(rows: Sequence[Row], folder: Path) -> list[Path]:
    """Write the table and the files of `transform_rows`; returns them. Files of an earlier run are replaced."""
    temporary = new_place(folder)
    temporary.mkdir()
    files = []
    for row in rows:
        if row["file"]:
            name = row["file"].removeprefix(f"{FOLDER}/")
            write_atomically(temporary / name, row["riot"].encode())
            files.append(folder / FOLDER / name)
    replace_folder(temporary, folder / FOLDER)
    plain = [{name: value for name, value in row.items() if name not in ("riot", "pair")} for row in rows]
    return [write_table(folder, "transforms", [from_rows(SCHEMAS["transforms"], plain)]), *files]

"""Tables with rows of pairs: the blocks of `qcrs`, `selected`, and `crs`."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.plan.work_item import WorkItem
from pipeline.stages.qcrs import COLUMNS
from pipeline.tables.outputs import from_columns, new_place, replace_folder, write_parquet
from pipeline.tables.results import Results, Row
from pipeline.tables.schemas import SCHEMAS, of_table
from riot.errors import needs_extra

with needs_extra("mine"):
    import pyarrow as pa


def pair_names(results: Results, members: tuple[int, ...]) -> Row:
    """The columns that identify a pair: shape numbers, names, classes."""
    p, q = members
    first, second = results.progress.items[p], results.progress.items[q]
    return {
        "i": int(results.numbers[p]),
        "j": int(results.numbers[q]),
        "name_i": first.name,
        "name_j": second.name,
        "class_i": first.cls,
        "class_j": second.cls,
    }


def stage_values(results: Results, table: str, members: tuple[int, ...], items: dict[str, WorkItem]) -> Row:
    """The columns that stages add to the row of a pair; a stage without an artifact of the pair adds none.

    ``items`` are the pair's work items by stage.
    """
    row: Row = {}
    for stage, added in of_table(table):
        artifact = results.artifact(items.get(stage.name))
        if artifact is not None:
            values = added.values(artifact)
            row |= {column.name: values[column.name] for column in added.columns if column.name in values}
    return row


def items_of_pairs(results: Results, table: str) -> dict[tuple[int, ...], dict[str, WorkItem]]:
    """Work items of the stages that add to a table, by pair and stage."""
    items: dict[tuple[int, ...], dict[str, WorkItem]] = {}
    for stage, _ in of_table(table):
        for members, item in results.by_members(stage.name).items():
            items.setdefault(members, {})[stage.name] = item
    return items


def selected_rows(results: Results) -> Iterator[Row]:
    """Rows of `selected`."""
    for rank, (pair, score) in enumerate(zip(results.pairs, results.qcrs, strict=True), start=1):
        yield {"rank": rank, **pair_names(results, pair), "qcrs": float(score)}


def crs_rows(results: Results) -> Iterator[Row]:
    """Rows of `crs`: of the selected pairs with a CRS, in order of selection."""
    items = items_of_pairs(results, "crs")
    for rank, item in enumerate(results.progress.work["crs"], start=1):
        if results.artifact(item) is not None:
            values = stage_values(results, "crs", item.members, items[item.members])
            names = pair_names(results, item.members)
            yield {"rank": rank, "i": names["i"], "j": names["j"], **values}


def write_qcrs(results: Results, folder: Path) -> list[Path]:
    """Write the scores into ``qcrs/``, a file for each batch of first shapes; returns the files.

    A new folder replaces the old one, so that no file of an earlier run with more blocks stays.
    """
    temporary = new_place(folder)
    names = []
    schema = SCHEMAS["qcrs"] if results.search is None else results.search.schema()
    for a in range(len(results.progress.batches)):
        name = Path(f"i_block={a:04d}") / "part-0.parquet"
        (temporary / name).parent.mkdir(parents=True)
        write_parquet(temporary / name, schema, [_block_row(results, a).cast(schema)])
        names.append(name)
    temporary.mkdir(exist_ok=True)
    replace_folder(temporary, folder / "qcrs")
    return [folder / "qcrs" / name for name in names]


def _block_row(results: Results, a: int) -> pa.Table:
    """All scored pairs whose first shape is in batch ``a``, ordered by i and j."""
    blocks = []
    for block in _collected(results, a) if "pairs" in results.progress.work else _blocks(results, a):
        block |= {name: results.numbers[block[name]] for name in ("i", "j")}
        keep = (block["i"] >= 0) & (block["j"] >= 0)
        blocks.append({name: column[keep] for name, column in block.items()})
    if not blocks:
        return SCHEMAS["qcrs"].empty_table()
    columns = {name: np.concatenate([block[name] for block in blocks]) for name in COLUMNS}
    # Blocks are ordered by (i, j), and all of one block's j come before the next one's.
    order = np.argsort(columns["i"], kind="stable")
    return from_columns(SCHEMAS["qcrs"], **{name: column[order] for name, column in columns.items()})


def _blocks(results: Results, a: int) -> Iterator[dict[str, Any]]:
    """The columns of each block in row ``a``; i and j are positions in the collection."""
    batches = results.progress.batches
    for item in results.progress.work["qcrs"]:
        assert item.block is not None
        artifact = results.artifact(item) if item.block[0] == a else None
        if artifact is not None:
            columns = {name: artifact.arrays[name] for name in COLUMNS}
            columns["i"] = batches[a].start + columns["i"].astype(np.int64)
            columns["j"] = batches[item.block[1]].start + columns["j"].astype(np.int64)
            yield columns


def _collected(results: Results, a: int) -> Iterator[dict[str, Any]]:
    """The columns of the collected pairs in row ``a``; i and j are positions in the collection."""
    for item in results.progress.work["pairs"]:
        artifact = results.artifact(item)
        if artifact is not None:
            batch = results.progress.batches[a]
            low, high = np.searchsorted(artifact.arrays["i"], [batch.start, batch.stop])
            yield {name: artifact.arrays[name][low:high] for name in COLUMNS}

"""Tables with rows of pairs: `qcrs`, `selected`, and `crs`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.plan.work_item import WorkItem
from pipeline.stages.qcrs import COLUMNS
from pipeline.store.artifact import Artifact
from pipeline.store.mapped import let_go
from pipeline.tables.outputs import from_columns, new_place, replace_folder, write_metadata, write_parquet
from pipeline.tables.results import Results, Row
from pipeline.tables.schemas import SCHEMAS, of_table
from riot.errors import needs_extra

with needs_extra("mine"):
    import pyarrow as pa
    import pyarrow.parquet as pq


Columns = dict[str, Any]
"""Columns of `qcrs` by name."""


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


ROWS = 1_000_000
"""Rows of a row group of `qcrs`, as readers of Parquet like it: about 10 MB."""

ROW_GROUPS = 12
"""Row groups of a file of `qcrs`: some 80 MB."""

PIECE = ROWS // 4
"""Rows that are put in order at a time: a row group has at most so many more."""

METADATA = "_metadata"
"""The file beside those of `qcrs` that has the statistics of every row group, as Dask reads it."""


def write_qcrs(results: Results, folder: Path) -> list[Path]:
    """Write the scores into ``qcrs/``, ordered by i and j from file to file; returns the files.

    A new folder replaces the old one, so that no file of an earlier run with more pairs stays.
    """
    temporary = new_place(folder)
    temporary.mkdir()
    schema = SCHEMAS["qcrs"] if results.search is None else results.search.schema()
    groups = _row_groups(results, schema)
    files: dict[str, pq.FileMetaData] = {}
    while first := list(islice(groups, 1)):
        name = f"part-{len(files):04d}.parquet"
        files[name] = write_parquet(temporary / name, schema, _of_a_file(first, groups), ("i", "j"))
    write_metadata(temporary / METADATA, schema, files)
    replace_folder(temporary, folder / "qcrs")
    return [folder / "qcrs" / name for name in (*files, METADATA)]


def _of_a_file(first: list[pa.Table], others: Iterator[pa.Table]) -> Iterator[pa.Table]:
    """Up to `ROW_GROUPS` row groups; ``first`` is emptied, so that nobody holds a group that is written."""
    yield first.pop()
    yield from islice(others, ROW_GROUPS - 1)


def _row_groups(results: Results, schema: pa.Schema) -> Iterator[pa.Table]:
    """All scored pairs, ordered by i and j, in tables of about `ROWS`; a single empty one if there are none."""
    waiting = [schema.empty_table()]
    written = rows = 0
    for piece in _collected(results) if "pairs" in results.progress.work else _scored(results):
        waiting.append(_table(piece, results, schema))
        rows += len(waiting[-1])
        if rows >= ROWS:
            yield pa.concat_tables(waiting)
            waiting, written, rows = [schema.empty_table()], written + rows, 0
    if rows or not written:
        yield pa.concat_tables(waiting)


def _table(piece: Columns, results: Results, schema: pa.Schema) -> pa.Table:
    """A piece, which is emptied, as a table of shapes, without the positions that have none."""
    piece |= {name: results.numbers[piece[name]] for name in ("i", "j")}
    keep = (piece["i"] >= 0) & (piece["j"] >= 0)
    columns = {field.name: piece.pop(field.name)[keep].astype(field.type.to_pandas_dtype()) for field in schema}
    return from_columns(schema, **columns)


def _scored(results: Results) -> Iterator[Columns]:
    """The columns of all blocks, ordered by i and j, in pieces of about `PIECE` rows; both are positions."""
    progress = results.progress
    by_rows: dict[int, list[WorkItem]] = {}
    for item in progress.work["qcrs"]:
        assert item.block is not None
        by_rows.setdefault(item.block[0], []).append(item)
    for a, items in sorted(by_rows.items()):
        columns_of = [progress.of_group(item.block[1]) for item in items if item.block is not None]
        # Large ones are mapped: of all blocks of a row only the rows in hand are in memory.
        blocks = [
            (group.start, artifact)
            for group, item in zip(columns_of, items, strict=True)
            if (artifact := _mapped(results, item)) is not None
        ]
        for rows in _spans(sum(map(len, columns_of)), len(progress.of_group(a))):
            piece = _rows_of(blocks, rows, progress.of_group(a).start)
            if piece:
                yield piece


def _mapped(results: Results, item: WorkItem) -> Artifact | None:
    """The artifact of a work item, none of it in memory although all of it was checked."""
    artifact = results.artifact(item)
    if artifact is not None:
        let_go(artifact)
    return artifact


def _rows_of(blocks: Sequence[tuple[int, Artifact]], span: tuple[int, int], start: int) -> Columns:
    """The pairs of a span of the rows of ``blocks``, each with the position of its first column, ordered by i and j.

    ``start`` is the position of the first row of all.
    """
    columns: Columns = {name: [] for name in COLUMNS}
    for first_column, block in blocks:
        first, last = np.searchsorted(block.arrays["i"], span)
        for name in COLUMNS:
            columns[name].append(np.array(block.arrays[name][first:last]))
        columns["j"][-1] = columns["j"][-1].astype(np.int64) + first_column
        let_go(block)
    if not blocks:
        return {}
    # Blocks are ordered by (i, j), and all of one block's j come before the next one's.
    order = np.argsort(np.concatenate(columns["i"]), kind="stable")
    for name in COLUMNS:  # one after the other, so that few are there twice
        columns[name] = np.concatenate(columns[name])[order]
    return {**columns, "i": columns["i"].astype(np.int64) + start}


def _spans(columns: int, rows: int) -> Iterator[tuple[int, int]]:
    """Spans of ``rows`` with about `PIECE` pairs each, if each has so many ``columns``."""
    step = max(1, PIECE // max(1, columns))
    return ((low, min(low + step, rows)) for low in range(0, rows, step))


def _collected(results: Results) -> Iterator[Columns]:
    """The columns of the collected pairs, ordered, in pieces; i and j are positions in the collection."""
    for item in results.progress.work["pairs"]:
        artifact = results.artifact(item)
        if artifact is not None:
            for low in range(0, len(artifact.arrays["i"]), PIECE):
                yield {name: artifact.arrays[name][low : low + PIECE] for name in COLUMNS}

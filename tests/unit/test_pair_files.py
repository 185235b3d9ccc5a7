"""The files of the table `qcrs`: sorted row groups with statistics, of the same types for every reader."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import duckdb
import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.dataset as ds
import pyarrow.parquet as pq
import pytest

from pipeline.tables.outputs import write_metadata, write_parquet
from pipeline.tables.schemas import SCHEMAS

ROWS, GROUPS = 600, 3
SCHEMA = SCHEMAS["qcrs"]
TYPES = {"i": "int32", "j": "int32", "score": "float32", "n": "int8", "trunk_i": "int32", "trunk_j": "int32"} | {
    "shift": "int8"
}


def rows() -> pa.Table:
    random = np.random.default_rng(2)
    i, j = (side[:ROWS] for side in np.triu_indices(50, 1))
    values = {"i": i, "j": j, "score": random.random(ROWS), "n": random.integers(3, 7, ROWS), "shift": -np.ones(ROWS)}
    values |= {name: random.integers(0, 900, ROWS) for name in ("trunk_i", "trunk_j")}
    return pa.table([pa.array(values[name]).cast(SCHEMA.field(name).type, safe=False) for name in TYPES], schema=SCHEMA)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    half, files = ROWS // 2, {}
    for number in range(2):
        groups = [rows().slice(number * half + k * half // GROUPS, half // GROUPS) for k in range(GROUPS)]
        name = f"part-{number:04d}.parquet"
        files[name] = write_parquet(tmp_path / name, SCHEMA, groups, ("i", "j"))
    write_metadata(tmp_path / "_metadata", SCHEMA, files)
    return tmp_path


def test_every_reader_finds_the_same_types_and_values(folder: Path) -> None:
    files, expected = str(folder / "*.parquet"), rows().to_pandas()
    described = duckdb.sql(f"DESCRIBE SELECT * FROM '{files}'").fetchall()
    names = {"int32": "INTEGER", "int8": "TINYINT", "float32": "FLOAT"}
    assert {row[0]: row[1] for row in described} == {name: names[kind] for name, kind in TYPES.items()}
    frames: list[Any] = [
        pd.read_parquet(folder),
        ds.dataset(folder, format="parquet").to_table().to_pandas(),
        duckdb.sql(f"SELECT * FROM '{files}' ORDER BY i, j").df(),
    ]
    if importlib.util.find_spec("polars"):
        frames.append(importlib.import_module("polars").read_parquet(files).to_pandas())
    for frame in frames:
        assert {name: str(kind) for name, kind in frame.dtypes.items()} == TYPES
        pd.testing.assert_frame_equal(frame, expected)


def test_row_groups_are_sorted_and_have_statistics_also_in_the_metadata_of_all(folder: Path) -> None:
    whole = pq.read_metadata(folder / "_metadata")
    own = [pq.read_metadata(file) for file in sorted(folder.glob("*.parquet"))]
    assert whole.num_rows == sum(metadata.num_rows for metadata in own) == ROWS
    groups = [metadata.row_group(k) for metadata in own for k in range(metadata.num_row_groups)]
    assert whole.num_row_groups == len(groups) == 2 * GROUPS
    last = (-1, -1)
    for number, group in enumerate(groups):
        assert [column.column_index for column in group.sorting_columns] == [0, 1]
        assert all(group.column(k).statistics.has_min_max for k in range(len(TYPES)))
        least, most = group.column(0).statistics.min, group.column(0).statistics.max
        assert last[0] <= least <= most
        last = (most, group.column(1).statistics.max)
        there = whole.row_group(number).column(0)
        assert there.file_path == f"part-{number // GROUPS:04d}.parquet" and there.statistics.max == most
    # A reader skips the row groups that cannot have what it looks for.
    dataset = ds.parquet_dataset(folder / "_metadata")
    first = ds.field("i") == 0
    fragments = [fragment.subset(first) for fragment in dataset.get_fragments(first)]
    assert sum(len(fragment.row_groups) for fragment in fragments) < len(groups)

"""Compare the folders of two finished runs value by value: ``python benchmarks/compare_runs.py A B [--ignore NAMES]``.

Every Parquet table is compared column by column, floats by their bits (nan equals nan); every .riot file but for its
history, which names the code that made it; every file to print by its bytes. The first differences of each file are
printed. Exit code 0: the runs are equal; 1: they differ; 2: a folder holds no run.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Collection, Iterator, Sequence
from functools import partial
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from riot.types import BoolArray

TABLES = ("*.parquet", "qcrs")
TRANSFORMS = "transforms/*.riot"
PRINTED = "print/**/*"

DIGESTS = "errors.key"
"""The column that holds a digest of code."""

SHOWN = 3
"""Differences that are printed for each file."""


def differences(first: Path, second: Path, ignored: Collection[str] = ()) -> Iterator[str]:
    """Yield a line for each difference between two runs, file by file.

    ``ignored`` holds names of tables and of columns (``table.column``) that are not compared.
    """
    for path in _files(first, second, TABLES):
        if path.parts[0].removesuffix(".parquet") not in ignored:
            yield from _either(first / path, second / path, path, partial(_tables, path=path, ignored=ignored))
    for path in _files(first, second, (TRANSFORMS,)):
        yield from _either(first / path, second / path, path, _transforms)
    for path in _files(first, second, (PRINTED,)):
        yield from _either(first / path, second / path, path, _bytes)


def _files(first: Path, second: Path, patterns: Sequence[str]) -> list[Path]:
    """The files of both folders that match a pattern, relative to their folder."""
    return sorted({
        file.relative_to(folder)
        for folder in (first, second)
        for pattern in patterns
        for file in folder.glob(pattern)
        if file.is_file() or file.name == "qcrs"
    })  # fmt: skip


def _either(first: Path, second: Path, path: Path, compare: Callable[[Path, Path], Iterator[str]]) -> Iterator[str]:
    missing = [str(file) for file in (first, second) if not file.exists()]
    lines = [f"{file} is missing" for file in missing] or list(compare(first, second))
    yield from (f"{path}: {line}" for line in lines[:SHOWN])
    if len(lines) > SHOWN:
        yield f"{path}: {len(lines) - SHOWN} more differences"


def _tables(first: Path, second: Path, path: Path, ignored: Collection[str]) -> Iterator[str]:
    name = path.parts[0].removesuffix(".parquet")
    left, right = (_read(file) for file in (first, second))
    columns = [column for column in left.column_names if f"{name}.{column}" not in ignored]
    others = [column for column in right.column_names if f"{name}.{column}" not in ignored]
    if columns != others:
        apart = sorted(set(columns) ^ set(others))
        yield f"columns {', '.join(apart)} are in one table only" if apart else "the columns have another order"
    if len(left) != len(right):
        yield f"{len(left)} rows and {len(right)} rows"
        return
    for column in columns:
        if column in others:
            yield from (f"{column}: {line}" for line in _columns(left[column], right[column]))


def _read(path: Path) -> pa.Table:
    """A table, of one file or of a folder of files, which stand in order of their names."""
    files = [path] if path.is_file() else sorted(path.rglob("*.parquet"))
    return pa.concat_tables([pq.ParquetFile(file).read() for file in files])


def _columns(left: pa.ChunkedArray, right: pa.ChunkedArray) -> Iterator[str]:
    if left.type != right.type:
        yield f"type {left.type} and {right.type}"
        return
    rows = np.flatnonzero(_differ(left.combine_chunks(), right.combine_chunks()))
    if len(rows):
        row = int(rows[0])
        yield f"{len(rows)} of {len(left)} rows differ, first row {row}: {left[row]!s:.60} and {right[row]!s:.60}"


def _differ(left: pa.Array, right: pa.Array) -> BoolArray:
    """Whether the rows of two arrays of one type and length differ: (n,) bool."""
    nulls = pc.is_null(left).to_numpy(zero_copy_only=False)
    differ: BoolArray = nulls != pc.is_null(right).to_numpy(zero_copy_only=False)
    if pa.types.is_list(left.type) or pa.types.is_large_list(left.type):
        lengths, others = (pc.fill_null(pc.list_value_length(array), 0).to_numpy() for array in (left, right))
        if not np.array_equal(lengths, others):  # rows of unlike lengths differ; the rest is compared alone
            alike = np.flatnonzero(lengths == others)
            differ |= lengths != others
            differ[alike] |= _differ(left.take(pa.array(alike)), right.take(pa.array(alike)))
            return differ
        values = _differ(pc.list_flatten(left), pc.list_flatten(right))
        differ[np.repeat(np.arange(len(left)), lengths)[values]] = True
        return differ
    if pa.types.is_floating(left.type):
        values, others = (pc.fill_null(array, 0.0).to_numpy() for array in (left, right))
        bits = np.dtype(f"u{values.dtype.itemsize}")
        return np.asarray(differ | ((values.view(bits) != others.view(bits)) & ~(np.isnan(values) & np.isnan(others))))
    unequal = pc.fill_null(pc.not_equal(left, right), False)
    return np.asarray(differ | unequal.to_numpy(zero_copy_only=False))


def _transforms(first: Path, second: Path) -> Iterator[str]:
    left, right = (json.loads(file.read_text(encoding="utf-8")) for file in (first, second))
    for name in sorted((left.keys() | right.keys()) - {"history"}):
        # As text: nan equals nan and -0.0 is not 0.0.
        if json.dumps(left.get(name)) != json.dumps(right.get(name)):
            yield f"{name} differs"


def _bytes(first: Path, second: Path) -> Iterator[str]:
    left, right = first.read_bytes(), second.read_bytes()
    if left != right:
        at = next((k for k, (a, b) in enumerate(zip(left, right, strict=False)) if a != b), min(len(left), len(right)))
        yield f"{len(left)} and {len(right)} bytes, which differ from byte {at} on"


def main(arguments: Sequence[str] | None = None) -> int:
    """Compare the runs that the command line names; returns the exit code."""
    parser = argparse.ArgumentParser(prog="benchmarks/compare_runs.py", description=__doc__.partition("\n")[0])
    parser.add_argument("first", type=Path, metavar="A", help="folder of a finished run, such as outputs/sample")
    parser.add_argument("second", type=Path, metavar="B")
    parser.add_argument(
        "--ignore",
        default="timings,digests",
        metavar="NAMES",
        help="tables, columns (table.column) and 'digests' (of code) not to compare; default: %(default)s",
    )
    chosen = parser.parse_args(arguments)
    for folder in (chosen.first, chosen.second):
        if not (folder / "shapes.parquet").is_file():
            print(f"compare_runs: {folder} holds no finished run; mine one first", file=sys.stderr)
            return 2
    ignored = {DIGESTS if name == "digests" else name for name in chosen.ignore.split(",")}
    unequal = list(differences(chosen.first, chosen.second, ignored))
    print("\n".join(unequal) if unequal else "The runs are equal.")
    return 1 if unequal else 0


if __name__ == "__main__":
    sys.exit(main())

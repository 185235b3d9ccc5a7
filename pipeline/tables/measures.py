"""A finished run in a few numbers, and its curves as CSV: ``python -m pipeline.tables.measures RUN -o DIR``.

``measures.json`` has counts and scores, ``deformation.csv`` the transforms in order, ``stages.csv`` what stages cost.
"""

from __future__ import annotations

import argparse
import csv
import io
import json
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pipeline.errors import StartError
from pipeline.exit_codes import BAD_START, CLEAN
from pipeline.store.store import write_atomically
from pipeline.tables.record import read_record
from pipeline.tables.results import Row
from riot.errors import needs_extra

with needs_extra("mine"):
    import pyarrow.parquet as pq

QUANTILES = {"max": 1.0, "q90": 0.9, "median": 0.5}
"""Quantiles of a run's scores, by name; each is the score of a pair, not a value between two."""

CURVES = {
    "deformation": ("transforms", ("rank", "iou", "bound_p", "bound_q", "crs", "qcrs")),
    "stages": ("timings", ("stage", "items", "stored_seconds")),
}
"""CSV files by name: the table that each is made from, and its columns. Of transforms only the certified results."""


def measures(folder: Path) -> dict[str, int | float | None]:
    """Counts of a finished run, and quantiles of CRS over selected and of IoU over the results, None without any.

    Raises `StartError` when there is no finished run in ``folder``.
    """
    record = read_record(folder)
    if record is None:
        raise StartError(f"{folder}: no finished run here; `python -m pipeline.run` makes one")
    values_by_name: dict[str, int | float | None] = dict(record["counts"])
    scores = {
        "crs": [row["score"] for row in rows(folder, "crs")],
        "iou": [row["iou"] for row in rows(folder, "transforms") if _is_result(row)],
    }
    for score, values in scores.items():
        for name, quantile in QUANTILES.items():
            values_by_name[f"{score}_{name}"] = float(np.quantile(values, quantile, method="lower")) if values else None
    return values_by_name


def _is_result(row: Row) -> bool:
    return bool(row["chosen"]) and row["status"] == "certified"


def rows(folder: Path, name: str) -> list[Row]:
    """Rows of a run's table."""
    table_rows: list[Row] = pq.read_table(folder / f"{name}.parquet").to_pylist()
    return table_rows


def write_measures(run: Path, target: Path) -> None:
    """Write the files; the same run gives the same bytes, but for the times in ``stages.csv``."""
    target.mkdir(parents=True, exist_ok=True)
    text = json.dumps(measures(run), indent=1)
    write_atomically(target / "measures.json", text.encode())
    for curve, (name, columns) in CURVES.items():
        kept = [row for row in rows(run, name) if name != "transforms" or _is_result(row)]
        stream = io.StringIO()
        writer = csv.DictWriter(stream, columns, extrasaction="ignore", lineterminator="\n")
        writer.writeheader()
        writer.writerows(kept)
        write_atomically(target / f"{curve}.csv", stream.getvalue().encode())


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    parser = argparse.ArgumentParser(
        prog="python -m pipeline.tables.measures", description=(__doc__ or "").splitlines()[0]
    )
    parser.add_argument("run", type=Path, help="folder of a finished run, such as outputs/sample")
    parser.add_argument("-o", "--output", type=Path, required=True, help="folder to write to")
    options = parser.parse_args(arguments)
    try:
        write_measures(options.run, options.output)
    except StartError as error:
        print(f"Cannot start: {error}", file=sys.stderr)
        return BAD_START
    return CLEAN


if __name__ == "__main__":
    sys.exit(main())

"""The tables of a sweep: the parameters and the outcome of each job, and the cost of its stages."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from pipeline.exit_codes import BAD_START, CLEAN, FAILED, WITH_ERRORS
from pipeline.tables import schemas as tables
from pipeline.tables.measures import measures, rows
from pipeline.tables.outputs import from_rows, new_place, write_parquet
from pipeline.tables.results import Row
from riot.errors import needs_extra

with needs_extra("mine"):
    import pyarrow as pa

PREFIX = "sweep="
"""Begins the name of a sweep's folder; the names of the swept parameters follow."""

STATUSES = {CLEAN: "clean", WITH_ERRORS: "errors", BAD_START: "refused", FAILED: "failed"}
"""The status of a job, by its exit code."""

Value = bool | int | float | str | None

COLUMNS = {bool: pa.bool_(), int: pa.int64(), float: pa.float64(), str: pa.string()}
"""The Arrow type of a parameter's column, by the type of its values."""


@dataclass(frozen=True)
class SweepJob:
    """One job of a sweep: the values of the swept parameters, by name, and the exit code.

    ``folder`` has the job's tables; it is None if the job did not finish, and ``message`` says why.
    """

    values: Mapping[str, Value]
    code: int
    folder: Path | None = None
    message: str = ""


def write_sweep(outputs: Path, jobs: Sequence[SweepJob]) -> Path:
    """Write ``sweep.parquet`` and ``timings.parquet`` of jobs that sweep over the same parameters; returns the folder.

    Rows are in order of the parameters, columns of parameters in order of name: the order of the jobs changes no byte
    of ``sweep.parquet``. Parameters are numbers where all their values are.
    """
    names = sorted(jobs[0].values)
    columns, kinds = {}, {}
    for name in names:
        columns[name], kinds[name] = _alike([job.values[name] for job in jobs])
    # Of equal jobs the last counts: its tables replaced those of the others.
    last_job = {values: number for number, values in enumerate(zip(*columns.values(), strict=True))}
    ordered = sorted(last_job, key=lambda values: [(value is not None, value) for value in values])
    ordered_jobs = [(dict(zip(names, values, strict=True)), jobs[last_job[values]]) for values in ordered]
    folder = outputs / (PREFIX + ",".join(names))
    folder.mkdir(parents=True, exist_ok=True)
    _write(folder / "sweep.parquet", tables.SWEEP, kinds, [values | _row(job, outputs) for values, job in ordered_jobs])
    stages = [values | stage for values, job in ordered_jobs if job.folder for stage in rows(job.folder, "timings")]
    _write(folder / "timings.parquet", tables.TIMINGS, kinds, stages)
    return folder


def _row(job: SweepJob, outputs: Path) -> Row:
    row: Row = {"status": STATUSES[job.code], "message": job.message}
    if job.folder is None:
        return row
    numbers = {name: value for name, value in measures(job.folder).items() if name in tables.SWEEP.names}
    return row | numbers | {"folder": Path(os.path.relpath(job.folder, outputs)).as_posix()}


def _write(path: Path, schema: pa.Schema, kinds: Mapping[str, pa.DataType], rows: Sequence[Row]) -> None:
    whole, temporary = tables.with_parameters(schema, kinds), new_place(path.parent)
    write_parquet(temporary, whole, [from_rows(whole, rows)])
    temporary.replace(path)


def _alike(values: Sequence[Value]) -> tuple[list[Value], pa.DataType]:
    """Give the values of a parameter one type: float for int and float together, str for any other mixture."""
    kinds = {type(value) for value in values if value is not None}
    if len(kinds) == 1:
        return list(values), COLUMNS[kinds.pop()]
    kind = float if kinds == {int, float} else str
    return [None if value is None else kind(value) for value in values], COLUMNS[kind]

"""Tables with rows of shapes: `shapes`, and the tables that belong to a single stage."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from pipeline.stages.stage import Ragged
from pipeline.tables.outputs import from_columns, from_rows
from pipeline.tables.results import Results, Row
from pipeline.tables.schemas import SCHEMAS, of_table
from riot.errors import needs_extra

with needs_extra("mine"):
    import pyarrow as pa
    import pyarrow.compute as pc


def own_tables() -> list[str]:
    """Names of the tables that belong to one stage of batches of shapes."""
    return [name for name in SCHEMAS if name != "shapes" and {stage.scope for stage, _ in of_table(name)} == {"batch"}]


def shape_rows(results: Results) -> Iterator[pa.Table]:
    """The table `shapes`, batch by batch: a row for each item that became a shape."""
    added = of_table("shapes")
    for number, batch in enumerate(results.progress.batches):
        columns: list[Mapping[str, Any]] = []
        for stage, stage_columns in added:
            artifact = results.artifact(results.progress.work[stage.name][number])
            columns.append({} if artifact is None else stage_columns.values(artifact))
        rows: list[Row] = []
        for index, position in enumerate(batch):
            if results.numbers[position] < 0:
                continue
            item = results.progress.items[position]
            values = {
                name: _plain(column[index]) for stage_columns in columns for name, column in stage_columns.items()
            }
            rows.append(
                {
                    "shape": int(results.numbers[position]),
                    "name": item.name,
                    "class": item.cls,
                    "source": item.shown_source,
                    "digest": item.digest,
                    **values,
                }
            )
        yield from_rows(SCHEMAS["shapes"], rows)


def stage_rows(results: Results, table: str) -> Iterator[pa.Table]:
    """The table of a single stage, batch by batch: the shapes' numbers, then the stage's columns."""
    ((stage, added),) = of_table(table)
    for batch, item in zip(results.progress.batches, results.progress.work[stage.name], strict=True):
        artifact = results.artifact(item)
        if artifact is None:
            continue
        columns = dict(added.values(artifact))
        numbers = results.numbers[batch.start : batch.stop]
        index = columns.pop("index", None)
        numbers = numbers if index is None else numbers[index]
        rows = from_columns(SCHEMAS[table], shape=numbers, **{name: _arrow(column) for name, column in columns.items()})
        yield rows if (numbers >= 0).all() else rows.filter(pc.greater_equal(rows["shape"], 0))


def near_duplicate_rows(results: Results) -> Iterator[Row]:
    """Rows of `near_duplicates`: of the clusters of at least two shapes, in order of their first shapes."""
    for item in results.progress.work["near_duplicates"]:
        artifact = results.artifact(item)
        if artifact is None:
            continue
        positions, cluster = artifact.arrays["positions"], artifact.arrays["cluster"]
        order = np.argsort(cluster, kind="stable")
        first, size = np.unique(cluster, return_counts=True)
        for k in order[np.isin(cluster[order], first[size > 1])]:
            yield {
                "cluster": int(results.numbers[cluster[k]]),
                "shape": int(results.numbers[positions[k]]),
                "name": results.progress.items[int(positions[k])].name,
            }


def _arrow(column: Any) -> Any:
    if isinstance(column, Ragged):
        return pa.ListArray.from_arrays(pa.array(column.offsets, type=pa.int32()), pa.array(column.values))
    return column


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value

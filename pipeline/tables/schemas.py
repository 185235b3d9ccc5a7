"""The tables of a run: one Arrow schema each, with the unit and the meaning of every column in its metadata.

Columns that come from a stage stand in the stage's file; here are those that a table has by itself. `shape`, `i` and
`j` are shape numbers: 0, 1, … in order of name, over the shapes of the run. Tables have plain columns only: pandas,
Arrow, Dask and DuckDB read them without this project. Outlines are columns of GeoParquet.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence

from pipeline.stages.all import STAGES
from pipeline.stages.stage import Column, Stage, TableColumns
from riot.errors import needs_extra

with needs_extra("mine"):
    import pyarrow as pa

KINDS = {
    "string": pa.string(),
    "bool": pa.bool_(),
    "int8": pa.int8(),
    "int16": pa.int16(),
    "int32": pa.int32(),
    "int64": pa.int64(),
    "float32": pa.float32(),
    "float64": pa.float64(),
    "polygon": pa.binary(),
}
"""Arrow types by name."""

GEOPARQUET = "1.1.0"
"""Version of the GeoParquet specification that the metadata of tables with outlines follows."""

SCORE = "score in [0, 1]"

NUMBER = (Column("shape", "int32", "shape", "shape number"),)
PAIR = (
    Column("i", "int32", "first shape (P)", "shape number"),
    Column("j", "int32", "second shape (Q)", "shape number"),
)
NAMES = (
    Column("name_i", "string", "name of the first shape"),
    Column("name_j", "string", "name of the second shape"),
    Column("class_i", "string", "class of the first shape, empty = none"),
    Column("class_j", "string", "class of the second shape, empty = none"),
)

OWN_COLUMNS: dict[str, tuple[str, tuple[Column, ...]]] = {
    "shapes": (
        "The shapes of the run, in order of name.",
        (
            Column("shape", "int32", "shape number, by which all tables join", "shape number"),
            Column("name", "string", "name of the shape, unique in the collection"),
            Column("class", "string", "class of the shape, empty = none"),
            Column("source", "string", "file, relative to the root of the collection, or definition of a sample"),
            Column("digest", "string", "SHA-256 of the source"),
        ),
    ),
    "near_duplicates": (
        "Shapes that are alike, cluster by cluster (likeness.near_duplicate); a shape like no other has no row.",
        (
            Column("cluster", "int32", "the first shape of the cluster", "shape number"),
            *NUMBER,
            Column("name", "string", "name of the shape"),
        ),
    ),
    "selected": (
        "The pairs that went on to CRS and refined trunks, best QCRS first.",
        (
            Column("rank", "int32", "1 = the best QCRS", "rank"),
            *PAIR,
            *NAMES,
            Column("qcrs", "float64", "QCRS of the pair", SCORE),
        ),
    ),
    "crs": ("", (Column("rank", "int32", "rank in `selected`", "rank"), *PAIR)),
    "transforms": (
        "Constructed transforms: by policy varied the chosen ones first, as chosen; then, and by the other policies "
        "all, certified, then approximate ones, least deformed first, then rejected ones as selected.",
        (
            Column(
                "rank", "int32", "1 = the best: chosen first, or, by policy global and paper, least deformed", "rank"
            ),
            Column("chosen", "bool", "whether it is a result of the run; the others were made to choose from"),
            Column("selected", "int32", "rank in `selected`", "rank"),
            *PAIR,
            *NAMES,
            Column("file", "string", "the transform, relative to the run's folder; empty if rejected"),
            Column("qcrs", "float64", "QCRS of the pair", SCORE),
        ),
    ),
    "fabrications": (
        "",
        (
            Column("rank", "int32", "rank in `transforms`", "rank"),
            *PAIR,
            *NAMES,
            Column("folder", "string", "its files, relative to the run's folder; empty unless certified"),
        ),
    ),
}
"""The columns that a table has by itself, before those of stages, and its meaning unless a stage gives it."""


def arrow_type(kind: str) -> pa.DataType:
    """The Arrow type of a column's kind, such as ``int32`` or ``list<int8>``."""
    element = re.fullmatch(r"list<(\w+)>", kind)
    # Parquet's own name for what a list holds, so that a table read back has the schema that was written.
    return pa.list_(pa.field("element", KINDS[element[1]])) if element else KINDS[kind]


def column(name: str, kind: pa.DataType, meaning: str, unit: str = "") -> pa.Field:
    """An Arrow field with its meaning and unit as metadata."""
    return pa.field(name, kind, metadata={"meaning": meaning, "unit": unit})


def schema(meaning: str, *columns: pa.Field) -> pa.Schema:
    """Columns with the meaning of the table as metadata."""
    return pa.schema(list(columns), metadata={"meaning": meaning})


def of_table(table: str) -> list[tuple[Stage, TableColumns]]:
    """The columns that stages add to a table, in order of the stages."""
    return [(stage, added) for stage in STAGES for added in stage.tables if added.table == table]


def _table(name: str) -> pa.Schema:
    meaning, own = OWN_COLUMNS.get(name, ("", () if name == "qcrs" else NUMBER))
    columns = list(own)
    for _, added in of_table(name):
        meaning = added.meaning or meaning
        names = [column.name for column in columns]
        end = names.index(added.after) + 1 if added.after else len(columns)
        columns[end:end] = added.columns
    return _schema(meaning, columns)


def _schema(meaning: str, columns: Sequence[Column]) -> pa.Schema:
    first = {
        column_of_stage.name: column_of_stage for column_of_stage in reversed(columns)
    }  # two stages may give one column, the later one's value counts
    ordered = [first[name] for name in dict.fromkeys(column_of_stage.name for column_of_stage in columns)]
    arrow_schema = schema(
        meaning,
        *(
            column(
                column_of_stage.name, arrow_type(column_of_stage.kind), column_of_stage.meaning, column_of_stage.unit
            )
            for column_of_stage in ordered
        ),
    )
    return arrow_schema.with_metadata(arrow_schema.metadata | _geometry_metadata(ordered))


def _geometry_metadata(columns: Sequence[Column]) -> dict[bytes, bytes]:
    """The key ``geo`` by which GeoPandas, DuckDB and QGIS know outlines, if there are any; the first is the primary."""
    outlines = {
        column.name: {
            "encoding": "WKB",
            "geometry_types": ["Polygon"],
            "crs": None,  # a plane of its own: the unit is in the column's metadata
            "edges": "planar",
            "orientation": "counterclockwise",
        }
        for column in columns
        if column.kind == "polygon"
    }
    if not outlines:
        return {}
    document = {"version": GEOPARQUET, "primary_column": next(iter(outlines)), "columns": outlines}
    return {b"geo": json.dumps(document).encode()}


ERRORS = _schema(
    "What went wrong, by item; the run went on.",
    (
        Column("item", "string", "name of the item, or the two names of a pair"),
        Column("stage", "string", "where it failed"),
        Column("key", "string", "content key of the work item, empty before there is one"),
        Column("type", "string", "type of the error"),
        Column("reason", "string", "reason in one word, where there is one"),
        Column("message", "string", "what, where, and what to do"),
        Column("attempts", "int32", "how often it was tried", "count"),
    ),
)

TIMINGS = _schema(
    "What each stage cost in this run.",
    (
        Column("stage", "string", "stage"),
        Column("items", "int64", "work items", "count"),
        Column("cached", "int64", "found in the store", "count"),
        Column("computed", "int64", "computed now", "count"),
        Column("failed", "int64", "failed", "count"),
        Column("blocked", "int64", "not tried, an input had failed", "count"),
        Column("seconds", "float64", "wall time of this run", "s"),
        Column("cpu_seconds", "float64", "processor time of all workers in this run", "s"),
        Column("stored_seconds", "float64", "time that the stage's artifacts took when they were computed", "s"),
        Column("peak_mb", "float64", "greatest resident memory of one worker up to then", "MiB"),
        Column(
            "critical_seconds",
            "float64",
            "time of the longest chain of work items that wait for one another: no number of workers is faster",
            "s",
        ),
        Column(
            "idle", "float64", "share of the workers' time in which they had nothing to do; null = none needed", "1"
        ),
        Column("read_mb", "float64", "arrays that workers read from the store", "MiB"),
        Column("written_mb", "float64", "artifacts that workers wrote", "MiB"),
    ),
)

SWEEP = _schema(
    "The jobs of a sweep, in order of its parameters, which come first.",
    (
        Column("status", "string", "clean, errors (see the job's table of errors), refused (no start), or failed"),
        Column("message", "string", "why it was refused or failed"),
        Column("folder", "string", "folder of the job's tables, relative to the outputs; null if there are none"),
        Column("items", "int64", "items of the collection", "count"),
        Column("shapes", "int64", "items that became shapes", "count"),
        Column("pairs", "int64", "pairs of shapes", "count"),
        Column("selected", "int64", "pairs that went on to CRS", "count"),
        Column("certified", "int64", "certified transforms", "count"),
        Column("approximate", "int64", "approximate transforms", "count"),
        Column("rejected", "int64", "rejected constructions", "count"),
        Column("swing_flat", "int64", "certified transforms that swing in one plane", "count"),
        Column("errors", "int64", "rows of the job's table of errors", "count"),
        Column("blocked", "int64", "work items that were not tried", "count"),
        Column("crs_max", "float64", "best CRS of the selected pairs; null = none, as of the others", SCORE),
        Column("crs_q90", "float64", "CRS that nine tenths of them do not exceed", SCORE),
        Column("crs_median", "float64", "CRS that half of them do not exceed", SCORE),
        Column("iou_max", "float64", "best IoU of the worse shape of the certified transforms; null = none", "1"),
        Column("iou_q90", "float64", "IoU that nine tenths of them do not exceed", "1"),
        Column("iou_median", "float64", "IoU that half of them do not exceed", "1"),
    ),
)

TABLES = tuple(dict.fromkeys([*OWN_COLUMNS, *(added.table for stage in STAGES for added in stage.tables)]))
"""Names of the tables of results."""

SCHEMAS = {name: _table(name) for name in TABLES} | {"errors": ERRORS, "timings": TIMINGS}
"""Every table by name; ``qcrs`` is a folder of files, the others ``<name>.parquet``."""


def with_parameters(schema: pa.Schema, kinds: Mapping[str, pa.DataType]) -> pa.Schema:
    """A table's schema after columns of the parameters that are swept over, of these types."""
    swept = [column(name, kind, "parameter that is swept over") for name, kind in kinds.items()]
    return pa.schema([*swept, *schema], metadata=schema.metadata)

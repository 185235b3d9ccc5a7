"""Write the tables and folders of a run under temporary names, and then rename them to replace the older ones."""

from __future__ import annotations

import contextlib
import re
import shutil
import unicodedata
import uuid
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from pipeline.config.schema import Config
from pipeline.store.filesystem.local import LocalFiles
from pipeline.store.store import TEMPORARY
from pipeline.tables import schemas as tables
from pipeline.tables.results import Row
from riot.errors import needs_extra

with needs_extra("mine"):
    import pyarrow as pa
    import pyarrow.parquet as pq

NAME_LENGTH = 40
"""Most characters of a shape's name in the name of a file: two of them and a rank stay readable in a listing (ours)."""


def run_folder(config: Config) -> Path:
    """The folder of a run's tables."""
    return config.outputs / config.dataset.name


def write_table(folder: Path, name: str, batches: Iterable[pa.Table]) -> Path:
    """Write the table ``name`` of `pipeline.tables.schemas.SCHEMAS`, batch by batch; returns its path."""
    path, temporary = folder / f"{name}.parquet", new_place(folder)
    write_parquet(temporary, tables.SCHEMAS[name], batches)
    return temporary.replace(path)


def write_parquet(
    path: Path, schema: pa.Schema, batches: Iterable[pa.Table], sorted_by: Sequence[str] = ()
) -> pq.FileMetaData:
    """Write batches as one Parquet file at ``path``, a row group each; its rows are ``sorted_by`` these columns.

    Returns the file's metadata.
    """
    sorting = [pq.SortingColumn(schema.get_field_index(name)) for name in sorted_by] or None
    # Sorted numbers differ little from the one before, and scores share their first bytes: both are smaller so.
    encodings = {field.name: "BYTE_STREAM_SPLIT" for field in schema if field.type == pa.float32()}
    encodings |= dict.fromkeys(sorted_by, "DELTA_BINARY_PACKED")
    with pq.ParquetWriter(
        path,
        schema,
        compression="zstd",
        sorting_columns=sorting,
        use_dictionary=[name for name in schema.names if name not in encodings] if encodings else True,
        column_encoding=encodings or None,
    ) as writer:
        for batch in batches:
            writer.write_table(batch, row_group_size=max(1, len(batch)))
            del batch  # before the next one is made
    return pq.read_metadata(path)


def write_metadata(path: Path, schema: pa.Schema, files: Mapping[str, pq.FileMetaData]) -> None:
    """Write the metadata of all files of a folder, by their names, as one file: statistics of every row group."""
    for name, metadata in files.items():
        metadata.set_file_path(name)
    pq.write_metadata(schema, path, list(files.values()))


def from_rows(schema: pa.Schema, rows: Iterable[Row]) -> pa.Table:
    """Rows as a table; what a row lacks is null."""
    return pa.Table.from_pylist(list(rows), schema=schema)


def from_columns(schema: pa.Schema, **columns: Any) -> pa.Table:
    """Columns, all of the schema's, as a table."""
    arrays = [pa.array(columns[field.name], type=field.type) for field in schema]
    return pa.Table.from_arrays(arrays, schema=schema)


def new_place(folder: Path) -> Path:
    """A new path in ``folder`` for something that is still being written."""
    return folder / f"{TEMPORARY}{uuid.uuid4().hex}"


def replace_folder(temporary: Path, target: Path) -> None:
    """Rename a finished folder to ``target``; an older folder of that name is removed."""
    if target.exists():
        old = new_place(target.parent)
        target.replace(old)
        temporary.replace(target)
        shutil.rmtree(old)
    else:
        temporary.replace(target)


@contextlib.contextmanager
def swept(folder: Path) -> Iterator[None]:
    """Remove half-written files from a run's folder on entry and on exit, unless another run uses the folder, too.

    On entry these are what a killed run left; on exit, what this run could not finish on a full disk.
    """
    files = LocalFiles(folder)

    def sweep() -> None:
        for name in files.names(""):
            if name.startswith(TEMPORARY):
                files.remove(name)

    with files.alone() as alone:
        if alone:
            sweep()
        try:
            yield
        finally:
            if alone:
                with contextlib.suppress(OSError):  # of a disk that became read-only: the next run removes it
                    sweep()


def file_name(name: str) -> str:
    """Make a name fit for a file's name: at most `NAME_LENGTH` ASCII letters, digits, dots and dashes; never empty.

    >>> file_name("Écrevisse 7/a"), file_name("魚")
    ('Ecrevisse-7-a', 'shape')
    """
    plain = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode()
    return re.sub(r"[^A-Za-z0-9.-]+", "-", plain)[:NAME_LENGTH].strip("-.") or "shape"

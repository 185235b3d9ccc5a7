"""The tables and shapes of a finished run, for studies."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from pipeline.config.schema import Config
from pipeline.errors import StartError
from pipeline.match.search import MinedRun, open_mined
from pipeline.match.shapes import read_shapes
from pipeline.store.location import Location
from pipeline.tables import schemas as tables
from riot.errors import needs_extra
from riot.geometry.shape import Shape
from riot.types import FloatArray, IntArray

with needs_extra("mine"):
    import pyarrow as pa
    import pyarrow.dataset as ds
    import pyarrow.parquet as pq


@dataclass(frozen=True, eq=False)
class StudiedRun:
    """A finished run whose shapes were mined by the code that is here."""

    mined: MinedRun

    @classmethod
    def open(cls, folder: Path, store: Location | None = None) -> StudiedRun:
        """The run in ``folder``, and its store if it is not where the run names it; raises as `open_mined`."""
        return cls(open_mined(folder, store))

    @property
    def config(self) -> Config:
        """The run's configuration."""
        return self.mined.config

    @property
    def classes(self) -> tuple[str, ...]:
        """The class of every shape, "" without one."""
        return self.mined.classes

    def table(self, name: str, *columns: str) -> pa.Table:
        """Columns of one of the run's tables, all if none are named; raises `StartError` if the table is gone."""
        path = self.mined.folder / f"{name}.parquet"
        try:
            return pq.read_table(path, columns=list(columns) or None)
        except OSError as error:
            raise StartError(f"{path}: gone or not readable; run the pipeline again to restore it") from error

    def values(self, name: str, column: str) -> FloatArray:
        """One column of numbers, nan = null."""
        return np.asarray(self.table(name, column).column(column).to_numpy(), dtype=np.float64)

    @cached_property
    def quick(self) -> pa.Table:
        """i, j, score of every pair that the run scored."""
        columns = ["i", "j", "score"]
        return ds.dataset(self.mined.folder / "qcrs", tables.SCHEMAS["qcrs"], format="parquet").to_table(
            columns=columns
        )

    def quick_scores(self, pairs: IntArray) -> FloatArray:
        """(k,) QCRS of ``pairs`` (k, 2), i < j, nan where the run set a pair aside.

        Raises `StartError` if it did not score them all.
        """
        count = len(self.mined.names)
        i, j = (self.quick.column(name).to_numpy().astype(np.int64) for name in ("i", "j"))
        keys, wanted = i * count + j, pairs[:, 0] * count + pairs[:, 1]
        order = np.argsort(keys, kind="stable")
        rows = np.minimum(np.searchsorted(keys[order], wanted), max(len(keys) - 1, 0))
        if not len(keys) or (keys[order][rows] != wanted).any():
            raise StartError(f"{self.mined.folder}: QCRS of some pairs is missing; this study needs qcrs.mode=all")
        return np.asarray(self.quick.column("score").to_numpy()[order][rows], dtype=np.float64)

    @cached_property
    def shapes(self) -> list[Shape]:
        """The shapes by number; raises `StartError` unless the run's store has all of them."""
        count = len(self.mined.names)
        shapes = read_shapes(self.mined, range(count))
        if len(shapes) != count:
            raise StartError(f"{self.mined.folder}: some shapes have no trunks because the work failed; run it again")
        return [shapes[number] for number in range(count)]

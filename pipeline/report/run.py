"""What the report reads of a finished run: `run.json`, the tables, and the transforms' files."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.dataset as ds
import pyarrow.parquet as pq

from pipeline.report.comparison import Comparison, read_comparison
from pipeline.report.histogram import Distribution, distribution
from pipeline.tables import schemas as tables
from pipeline.tables.partner_search import Search, read_search
from riot.errors import RiotError
from riot.types import FloatArray

Row = dict[str, Any]


class ReportError(RiotError, FileNotFoundError):
    """A folder that does not hold a finished run."""


@dataclass(frozen=True)
class TransformRow:
    """One row of `transforms`; see `pipeline.tables.schemas.TRANSFORMS` for the meaning, nan = null."""

    rank: int
    name_p: str
    name_q: str
    class_p: str
    class_q: str
    status: str
    reason: str
    message: str
    file: str
    qcrs: float
    crs: float
    s_edge: float
    s_angle: float
    s_area: float
    n: int
    iou: float
    iou_p: float
    iou_q: float
    bound_p: float
    bound_q: float
    hausdorff_p: float
    hausdorff_q: float
    mean_distance_p: float
    mean_distance_q: float
    change_ratio: float
    bending_p: float
    bending_q: float
    direction_p: float
    direction_q: float
    overlap_p: float
    overlap_q: float
    gap_p: float
    gap_q: float
    hinge_p: float
    hinge_q: float
    swings_flat: bool | None
    """None = not planned."""

    @property
    def classes(self) -> tuple[str, ...]:
        """The classes of its shapes, each once, without those of shapes that have none."""
        return tuple(dict.fromkeys(name for name in (self.class_p, self.class_q) if name))

    @property
    def approximate(self) -> bool:
        """Whether it is not exact: made by the paper's method."""
        return self.status == "approximate"

    @property
    def area_residual(self) -> float:
        """The greatest of the certificate's areas."""
        return _greatest(self.overlap_p, self.overlap_q, self.gap_p, self.gap_q)

    @property
    def hinge_residual(self) -> float:
        """The greatest distance at a hinge."""
        return _greatest(self.hinge_p, self.hinge_q)


@dataclass(frozen=True)
class Run:
    """A finished run as the report needs it."""

    folder: Path
    facts: Row
    """`run.json`."""
    shapes: int
    classes: int
    pairs: int
    pairs_without_trunks: int
    selected: int
    transforms: tuple[TransformRow, ...]
    fabrications: tuple[Row, ...]
    errors: tuple[Row, ...]
    timings: tuple[Row, ...]
    s_r: Distribution
    qcrs: Distribution
    crs: Distribution
    iou: Distribution
    comparison: Comparison | None
    """The paper's method beside the exact one; None when nothing was made by both."""
    search: Search | None
    """What the search for partners took; None when all pairs were scored."""

    @property
    def counts(self) -> Mapping[str, int]:
        """What `run.json` counts."""
        counts: Mapping[str, int] = self.facts.get("counts", {})
        return counts

    @property
    def policy(self) -> str:
        """How pairs were selected."""
        return str(self.facts.get("configuration", {}).get("select", {}).get("policy", ""))

    @property
    def made(self) -> tuple[TransformRow, ...]:
        """Transforms that have a file: the certified ones, then the approximate ones, best first."""
        return tuple(row for row in self.transforms if row.file)

    @property
    def certified(self) -> tuple[TransformRow, ...]:
        """Transforms that passed, best first."""
        return tuple(row for row in self.made if not row.approximate)

    @property
    def approximate(self) -> tuple[TransformRow, ...]:
        """Transforms by the paper's method, best first."""
        return tuple(row for row in self.made if row.approximate)

    @property
    def rejected(self) -> tuple[TransformRow, ...]:
        """Constructions that were refused."""
        return tuple(row for row in self.transforms if not row.file)


def read_run(folder: Path) -> Run:
    """Read a run's folder; raises `ReportError` if a table or `run.json` is missing."""
    missing = [name for name in _NEEDED if not (folder / name).exists()]
    if missing:
        raise ReportError(
            f"{folder} does not hold a finished run: {', '.join(missing)} missing; "
            "finish the run with `python -m pipeline.run`, then write the report again"
        )
    facts = json.loads((folder / "run.json").read_text(encoding="utf-8"))
    shapes = pq.read_table(folder / "shapes.parquet", columns=["class"]).column("class").to_pylist()
    made, timings = _rows(folder, "transforms"), _rows(folder, "timings")
    transforms = tuple(_transform_row(row) for row in made)
    # Closing over the count keeps the pass over all pairs a single one.
    lonely = [0]

    def scores() -> Iterator[FloatArray]:
        for batch in ds.dataset(folder / "qcrs", tables.QCRS, format="parquet").to_batches(columns=["score", "n"]):
            lonely[0] += int((batch.column("n").to_numpy() == 0).sum())
            yield batch.column("score").to_numpy()

    qcrs = distribution(scores())
    return Run(
        folder=folder,
        facts=facts,
        shapes=len(shapes),
        classes=len({name for name in shapes if name}),
        pairs=qcrs.total,
        pairs_without_trunks=lonely[0],
        selected=pq.read_metadata(folder / "selected.parquet").num_rows,
        transforms=transforms,
        fabrications=tuple(_rows(folder, "fabrications")),
        errors=tuple(_rows(folder, "errors")),
        timings=tuple(timings),
        s_r=distribution([_column(folder, "reversibility", "score")]),
        qcrs=qcrs,
        crs=distribution([_column(folder, "crs", "score")]),
        iou=distribution([np.array([row.iou for row in transforms if row.file])]),
        comparison=read_comparison(made, timings),
        search=_search(folder / "qcrs"),
    )


_NEEDED = (
    "run.json",
    "qcrs",
    *(
        f"{name}.parquet"
        for name in ("shapes", "reversibility", "selected", "crs", "transforms", "fabrications", "errors", "timings")
    ),
)


def _search(folder: Path) -> Search | None:
    first = next(iter(sorted(folder.rglob("*.parquet"))), None)
    return None if first is None else read_search(pq.read_schema(first).metadata)


def _rows(folder: Path, name: str) -> list[Row]:
    rows: list[Row] = pq.read_table(folder / f"{name}.parquet").to_pylist()
    return rows


def _column(folder: Path, name: str, column: str) -> FloatArray:
    table = pq.read_table(folder / f"{name}.parquet", columns=[column])
    return np.asarray(table.column(column).to_numpy(), dtype=np.float64)


def _transform_row(row: Row) -> TransformRow:
    sides = {"name_p": "name_i", "name_q": "name_j", "class_p": "class_i", "class_q": "class_j"}
    values: dict[str, Any] = {}
    for field in fields(TransformRow):
        value = row.get(sides.get(field.name, field.name))
        if value is None:
            value = {"int": 0, "float": math.nan, "str": "", "bool | None": None}[str(field.type)]
        values[field.name] = value
    return TransformRow(**values)


def _greatest(*values: float) -> float:
    known = [abs(value) for value in values if math.isfinite(value)]
    return max(known, default=math.nan)

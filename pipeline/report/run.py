"""What the report reads of a finished run: `run.json`, the tables, and the transforms' files."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import shapely

from pipeline.report.comparison import Comparison, read_comparison
from pipeline.report.histogram import Distribution, distribution
from pipeline.report.rows import ErrorRow, PuzzleRow, TimingRow, TransformRow, typed_row
from pipeline.tables import schemas as tables
from pipeline.tables.measures import rows
from pipeline.tables.partner_search import PartnerSearch, read_search
from pipeline.tables.record import RECORD
from pipeline.tables.results import Row
from riot.errors import RiotError, needs_extra
from riot.types import FloatArray

with needs_extra("mine"):
    import pyarrow.dataset as ds
    import pyarrow.parquet as pq


class ReportError(RiotError, FileNotFoundError):
    """A folder that does not hold a finished run."""


@dataclass(frozen=True, eq=False)
class ShapeClass:
    """A class: its name, its first shape's outline, (m, 2), empty if not known, and its number of selected pairs."""

    name: str
    outline: FloatArray
    selected: int


@dataclass(frozen=True, eq=False)
class ReportedRun:
    """What the report shows of a finished run."""

    folder: Path
    facts: Row
    """`run.json`."""
    shapes: int
    classes: tuple[ShapeClass, ...]
    """In order of name, whatever its case; none if no shape has a class."""
    pairs: int
    pairs_without_trunks: int
    selected: int
    transforms: tuple[TransformRow, ...]
    puzzles: tuple[PuzzleRow, ...]
    errors: tuple[ErrorRow, ...]
    timings: tuple[TimingRow, ...]
    s_r: Distribution
    qcrs: Distribution
    crs: Distribution
    iou: Distribution
    comparison: Comparison | None
    """The paper's method beside the exact one; None when nothing was made by both."""
    search: PartnerSearch | None
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
    def address(self) -> str:
        """Where the folder will be published, with a slash at its end; "" = nowhere."""
        return str(self.facts.get("configuration", {}).get("address", ""))

    @property
    def name(self) -> str:
        """The name of the collection."""
        dataset = self.facts.get("dataset", self.folder.name)
        return str(dataset.get("name", self.folder.name) if isinstance(dataset, Mapping) else dataset)

    @property
    def seconds(self) -> float:
        """Wall time of all stages."""
        return sum(row.seconds for row in self.timings if row.seconds > 0.0)

    @property
    def constructed(self) -> tuple[TransformRow, ...]:
        """Transforms that have a file: the certified ones, then the approximate ones, best first."""
        return tuple(row for row in self.transforms if row.file)

    @property
    def certified(self) -> tuple[TransformRow, ...]:
        """Transforms that passed, best first."""
        return tuple(row for row in self.constructed if not row.approximate)

    @property
    def approximate(self) -> tuple[TransformRow, ...]:
        """Transforms by the paper's method, best first."""
        return tuple(row for row in self.constructed if row.approximate)

    @property
    def rejected(self) -> tuple[TransformRow, ...]:
        """Constructions that were refused."""
        return tuple(row for row in self.transforms if not row.file)


def read_run(folder: Path) -> ReportedRun:
    """Read a run's folder; raises `ReportError` if a table or `run.json` is missing."""
    missing = [name for name in _NEEDED if not (folder / name).exists()]
    if missing:
        raise ReportError(
            f"{folder} does not hold a finished run: {', '.join(missing)} missing; "
            "finish the run with `python -m pipeline.run`, then write the report again"
        )
    facts = json.loads((folder / RECORD).read_text(encoding="utf-8"))
    tables_read = {name: rows(folder, name) for name in ("transforms", "fabrications", "errors", "timings")}
    # The report shows what the run chose, and what it could not make.
    shown = (row for row in tables_read["transforms"] if row["chosen"] is not False or not row["file"])
    transforms = tuple(typed_row(TransformRow, row) for row in shown)
    # Closing over the count keeps the pass over all pairs a single one.
    pairs_without_trunks = [0]

    def scores() -> Iterator[FloatArray]:
        for batch in ds.dataset(folder / "qcrs", tables.SCHEMAS["qcrs"], format="parquet").to_batches(
            columns=["score", "n"]
        ):
            pairs_without_trunks[0] += int((batch.column("n").to_numpy() == 0).sum())
            yield batch.column("score").to_numpy().astype(np.float64)

    qcrs = distribution(scores())
    return ReportedRun(
        folder=folder,
        facts=facts,
        shapes=pq.read_metadata(folder / "shapes.parquet").num_rows,
        classes=_classes(folder),
        pairs=qcrs.total,
        pairs_without_trunks=pairs_without_trunks[0],
        selected=pq.read_metadata(folder / "selected.parquet").num_rows,
        transforms=transforms,
        puzzles=tuple(typed_row(PuzzleRow, row) for row in tables_read["fabrications"]),
        errors=tuple(typed_row(ErrorRow, row) for row in tables_read["errors"]),
        timings=tuple(typed_row(TimingRow, row) for row in tables_read["timings"]),
        s_r=distribution([_column(folder, "reversibility", "score")]),
        qcrs=qcrs,
        crs=distribution([_column(folder, "crs", "score")]),
        iou=distribution([np.array([row.iou for row in transforms if row.file])]),
        comparison=read_comparison(tables_read["transforms"], tables_read["timings"]),
        search=_search(folder / "qcrs"),
    )


_NEEDED = (
    RECORD,
    "qcrs",
    *(
        f"{name}.parquet"
        for name in ("shapes", "reversibility", "selected", "crs", "transforms", "fabrications", "errors", "timings")
    ),
)


def _classes(folder: Path) -> tuple[ShapeClass, ...]:
    table = pq.read_table(folder / "shapes.parquet", columns=["class", "outline"])
    first: dict[str, int] = {}
    for number, name in enumerate(table.column("class").to_pylist()):
        first.setdefault(name or "", number)
    first.pop("", None)
    selected = pq.read_table(folder / "selected.parquet", columns=["class_i", "class_j"]).to_pylist()
    pairs = Counter(name for pair in selected for name in set(pair.values()))
    outline = table.column("outline")
    return tuple(
        ShapeClass(name, _points(outline[first[name]].as_py()), pairs[name])
        for name in sorted(first, key=lambda name: (name.lower(), name))
    )


def _points(wkb: bytes | None) -> FloatArray:
    return np.empty((0, 2)) if wkb is None else np.asarray(shapely.from_wkb(wkb).exterior.coords[:-1])


def _search(folder: Path) -> PartnerSearch | None:
    first = next(iter(sorted(folder.rglob("*.parquet"))), None)
    return None if first is None else read_search(pq.read_schema(first).metadata)


def _column(folder: Path, name: str, column: str) -> FloatArray:
    table = pq.read_table(folder / f"{name}.parquet", columns=[column])
    return np.asarray(table.column(column).to_numpy(), dtype=np.float64)

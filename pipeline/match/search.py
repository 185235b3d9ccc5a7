"""Open a finished run, and search it for the best partners of a new shape."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.config.build import make_config
from pipeline.config.schema import Config
from pipeline.errors import ConfigError, PayloadError, StartError
from pipeline.explain.causes import explain, gather
from pipeline.match.index import load_index
from pipeline.plan.work_item import Recipe
from pipeline.stages.all import BY_NAME
from pipeline.store.keys import digest_bytes
from pipeline.store.location import Location, parse_location
from pipeline.store.store import Entry, Store
from pipeline.tables.record import ARTIFACTS, RECORD, read_record
from riot.errors import needs_extra
from riot.geometry.shape import Shape
from riot.geometry.silhouette import read
from riot.scores.index import TrunkIndex, best_partners
from riot.scores.qcrs import BlockScores
from riot.scores.reversibility import reversibility
from riot.scores.trunk_stack import TrunkStack, stack
from riot.scores.trunks import Trunks, compared_trunks
from riot.types import IntArray

with needs_extra("mine"):
    import pyarrow.parquet as pq

SHAPES = "shapes.parquet"
AGAIN = "the command that made the run makes it again, and computes only what is missing"
"""Ends every message about a run that is not whole."""


@dataclass(frozen=True, eq=False)
class MinedRun:
    """What a search needs of a finished run.

    ``names``, ``classes`` and ``digests`` are by shape number. ``trunks`` are the keys of its batches of trunks,
    in the collection's order, ``numbers`` (items,) int64 the shape number of each item of these batches, −1 without
    a shape.
    """

    folder: Path
    dataset: str
    config: Config
    store: Store
    names: tuple[str, ...]
    classes: tuple[str, ...]
    digests: tuple[str, ...]
    trunks: tuple[str, ...]
    numbers: IntArray

    @property
    def unknown(self) -> int:
        """The number of shapes without trunks, because the work on their batch failed."""
        return len(self.names) - int((self.numbers >= 0).sum())

    def index(self, note: Callable[[str], None]) -> TrunkIndex:
        """The index over all its trunks, saved or built anew (`load_index`); raises `StartError`."""
        try:
            return load_index(self.store, self.trunks, note)
        except (KeyError, PayloadError, OSError) as error:
            reason = error.args[0] if isinstance(error, KeyError) else error
            raise StartError(
                f"{self.store.root}: trunks of {self.folder} are gone or altered ({reason}); {AGAIN}"
            ) from error


@dataclass(frozen=True, eq=False)
class Query:
    """A shape to be matched: name and digest of its file, its trunks for QCRS, and these as a stack for the search."""

    name: str
    digest: str
    trunks: Trunks
    stacked: TrunkStack


@dataclass(frozen=True, eq=False)
class MatchResult:
    """The best partners, best first (``scores.j`` are shape numbers).

    ``itself`` is the shape of the collection with the query's file, None without one; ``compared`` counts the shapes
    of which the distance of two trunks was computed.
    """

    scores: BlockScores
    itself: int | None
    compared: int


def open_mined(folder: Path, store: Location | None = None) -> MinedRun:
    """Open the finished run in ``folder``; ``store`` is needed only if its store was moved.

    Raises `StartError` if there is no such run, if other code mined it, or if its store is gone.
    """
    record = _record(folder)
    config = _config(folder, record)
    where = Store(store or parse_location(record.get("store", config.store)), config.signing)
    if not where.files.exists():
        moved = "give store=LOCATION if it was moved" if store is None else "give the folder that it is in now"
        raise StartError(f"{where.root}: the store of {folder} is gone; {moved}; else {AGAIN}")
    table = _shapes(folder, record)
    number_of = {digest: number for number, digest in zip(table["shape"], table["digest"], strict=True)}
    of_trunks, of_ingest = (BY_NAME[stage].recipe(config) for stage in ("trunks", "ingest"))
    batches = []
    for key in _artifact_keys(folder, "trunks"):
        trunks = _entry(where, folder, of_trunks, key)
        ingest = _entry(where, folder, of_ingest, trunks.parts["inputs"][0])
        numbers = [number_of.get(digest, -1) for digest in ingest.parts["inputs"]]
        if max(numbers) >= 0:
            batches.append((max(numbers), key, numbers))
    batches.sort()  # shapes are numbered in the order of the collection
    return MinedRun(
        folder=folder,
        dataset=str(record["dataset"]),
        config=config,
        store=where,
        names=tuple(table["name"]),
        classes=tuple(table["class"]),
        digests=tuple(table["digest"]),
        trunks=tuple(key for _, key, _ in batches),
        numbers=np.array([number for *_, numbers in batches for number in numbers], dtype=np.int64),
    )


def read_query(mined: MinedRun, path: Path) -> Query:
    """Read a picture, and find its trunks as the run did for the collection.

    Raises `riot.errors.SilhouetteError`, or OSError when there is no such file.
    """
    digest = digest_bytes(path.read_bytes())
    trunks = trunks_as_mined(mined, read(path, mined.config.shape))
    return Query(path.stem, digest, trunks, stack([trunks]))


def trunks_as_mined(mined: MinedRun, shape: Shape) -> Trunks:
    """Find the trunks of a shape as the run did for the collection."""
    config = mined.config
    return compared_trunks(
        shape, config.qcrs.variant, config.trunks, lambda: reversibility(shape, config.reversibility)
    )


def match(mined: MinedRun, index: TrunkIndex, query: Query, count: int) -> MatchResult:
    """The ``count`` best partners of a shape by QCRS, exact; a shape of the same file is left out."""
    itself = mined.digests.index(query.digest) if query.digest in mined.digests else None
    own_rows = np.flatnonzero(mined.numbers == (-2 if itself is None else itself))
    excluded = [int(own_rows[0])] if len(own_rows) else [-1]
    search = best_partners(index, query.stacked, count, mined.config.qcrs.sigmas, itself=excluded)
    columns = {**vars(search.scores), "j": mined.numbers[search.scores.j].astype(np.int32)}
    return MatchResult(BlockScores(**columns), itself, search.compared)


def _record(folder: Path) -> Mapping[str, Any]:
    if not folder.is_dir():
        what = "is not a folder" if folder.exists() else "does not exist"
        raise StartError(f"{folder}: {what}; give the folder of a run's tables, such as outputs/sample")
    record = read_record(folder)
    if record is not None:
        return record
    if (folder / RECORD).exists():
        raise StartError(f"{folder / RECORD}: damaged, or of another version of this program; {AGAIN}")
    runs = sorted(path.parent for path in folder.glob(f"*/{RECORD}"))
    if runs:
        raise StartError(f"{folder}: not itself a run; give one of {', '.join(map(str, runs))}")
    raise StartError(
        f"{folder}: no finished run here ({RECORD} is missing): it was stopped, or is not done yet; "
        "the same command as before goes on with it"
    )


def _config(folder: Path, record: Mapping[str, Any]) -> Config:
    try:
        return make_config(record["configuration"])
    except (ConfigError, KeyError, TypeError) as error:
        raise StartError(f"{folder}: mined by another version of this program ({error}); mine it again") from error


def _shapes(folder: Path, record: Mapping[str, Any]) -> dict[str, list[Any]]:
    path = folder / SHAPES
    try:
        if digest_bytes(path.read_bytes()) != record["files"][SHAPES]:
            raise StartError(f"{path}: altered since the run wrote it; {AGAIN}")
    except (OSError, KeyError) as error:
        raise StartError(f"{path}: gone or not readable; {AGAIN}") from error
    columns: dict[str, list[Any]] = pq.ParquetFile(path).read(columns=["shape", "name", "class", "digest"]).to_pydict()
    return columns


def _artifact_keys(folder: Path, stage: str) -> list[str]:
    path = folder / ARTIFACTS
    try:
        return [str(key) for key in json.loads(path.read_bytes()).get(stage, ())]
    except (OSError, ValueError, AttributeError) as error:
        raise StartError(f"{path}: gone or damaged; {AGAIN}") from error


def _entry(store: Store, folder: Path, recipe: Recipe, key: str) -> Entry:
    """The manifest of a batch; raises `StartError` if the code here would give it another key."""
    stage = recipe.stage
    try:
        entry = store.entry(stage, key)
    except (PayloadError, OSError) as error:
        raise StartError(f"{store.root}: altered since {folder} was made ({error}); {AGAIN}") from error
    if entry is None:
        raise StartError(
            f"{store.root}: {stage}/{key[:12]}, of {folder}, is gone; give store=LOCATION if it is another; "
            f"else {AGAIN}"
        )
    parts = recipe.parts(entry.parts["inputs"])
    if parts.key() != key:
        changes = "; ".join(explain(parts.to_json(), gather([entry.parts]))[:3])
        raise StartError(
            f"{folder}: mined by other code or libraries than are here, whose trunks may differ ({changes}); "
            "mine it again, or use the version that mined it"
        )
    return entry

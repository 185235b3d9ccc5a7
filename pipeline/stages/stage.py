"""The definition of a stage: its parameters, how its work is planned and done, and what the tables show of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Any, Literal

from pipeline.config.schema import Config, QcrsConfig, ShapeConfig
from pipeline.plan.code_digest import code_digests, library_versions
from pipeline.plan.progress import Progress
from pipeline.plan.sub_block import SubBlock
from pipeline.plan.work_item import Recipe, WorkItem
from pipeline.store.artifact import AnyArray, Artifact
from pipeline.store.keys import canonical_value

Scope = Literal["batch", "block", "part", "collection", "shape", "pair"]
"""The extent of a work item: a batch of shapes, the pairs between two groups of batches (or a query and shards), a
part of all pairs, the whole collection, a shape, or a pair."""

COUNTED: Mapping[Scope, str] = {
    "batch": "shapes",
    "shape": "shapes",
    "block": "pairs",
    "pair": "pairs",
    "part": "",
    "collection": "",
}
"""What a work item of each scope has several of, in the plural, where it is counted."""


@dataclass(frozen=True)
class Column:
    """A column of a table; ``kind`` is an Arrow type by name, such as ``int32``, ``float64`` or ``list<int32>``.

    The kind ``polygon`` is well-known binary (`riot.geometry.wkb`), which the table's metadata declares as GeoParquet.
    """

    name: str
    kind: str
    meaning: str
    unit: str = ""


@dataclass(frozen=True)
class Ragged:
    """Values of a column of lists: row k has ``values[offsets[k]:offsets[k + 1]]``."""

    offsets: AnyArray
    values: AnyArray


@dataclass(frozen=True)
class TableColumns:
    """Columns that a stage adds to a table.

    ``values`` computes them, by name, from an artifact of the stage. A stage of batches gives arrays, lists or `Ragged`
    with an entry for each shape of the batch; if a shape may have several entries, an array ``index`` gives the shape
    of each. A stage of pairs gives plain values; a missing one is null. ``meaning`` is that of a table which the stage
    adds. The columns follow the column ``after`` of the table, or come last.
    """

    table: str
    columns: tuple[Column, ...]
    values: Callable[[Artifact], Mapping[str, Any]]
    meaning: str = ""
    after: str = ""


@dataclass(frozen=True)
class SubBlocks:
    """How the work of a block is divided, to find the pairs of it that hang or kill a worker.

    ``join`` makes the block's artifact from those of its sub-blocks, except the lost ones. With ``columns_are_shapes``
    a block lies between two groups of batches; else between a query and shards, which count as a single column.
    """

    join: Callable[[Sequence[Artifact], Sequence[SubBlock]], Artifact]
    columns_are_shapes: bool

    def whole(self, progress: Progress, item: WorkItem) -> SubBlock:
        """The sub-block that is the whole block."""
        rows, columns = self._positions(progress, item)
        return SubBlock(item.spec, (0, len(rows)), (0, len(columns)))

    def members(self, progress: Progress, item: WorkItem, sub_block: SubBlock) -> list[int]:
        """Positions of the shapes of a sub-block's rows, and of its columns where these are shapes."""
        rows, columns = self._positions(progress, item)
        members = set(rows[slice(*sub_block.rows)])
        if self.columns_are_shapes:
            members |= set(columns[slice(*sub_block.columns)])
        return sorted(members)

    def _positions(self, progress: Progress, item: WorkItem) -> tuple[range, range]:
        """Positions of the shapes of a block's rows and columns; shards count as one column."""
        if not self.columns_are_shapes:
            return range(item.members[0], item.members[-1] + 1), range(1)
        assert item.block is not None, "a stage of blocks gives each work item its block"
        a, b = item.block
        return progress.of_group(a), progress.of_group(b)


def _as_it_is(artifact: Artifact) -> Any:
    return artifact


def _always(config: Config) -> bool:
    return True


@dataclass(frozen=True)
class Stage:
    """A stage of the method. All of it is in one file: a module of `pipeline.stages` that defines ``STAGE``.

    Attributes
    ----------
    name : str
        Its name in keys, tables and messages.
    unit : str
        What its work items are, in the plural, for messages.
    after : tuple of str
        Stages that come before it.
    parameters : tuple of str
        Groups of the configuration, or single parameters, that ``run`` reads; they enter its keys.
    items : callable
        Plans its work items from what is known so far (`Progress`).
    run : callable
        (inputs, parameters, spec) → artifact. All code that it reaches enters the stage's keys.
    scope : Scope
        The extent of a work item.
    prepare : callable
        Turns an artifact into an input of ``run``, once for all work items of a task.
    known_after : str
        The stage whose results decide its work items; empty if they are known before anything is computed.
    wanted : callable
        Whether a run with this configuration has the stage.
    at_most : callable
        The greatest number of work items with this configuration, for plans made before they are known.
    here : bool
        Whether it runs in the run's own process, because its work is too small for a worker.
    bundle : int
        Most work items in a task. A task should last a second or more; an artifact should be small enough to be reused.
    tile : int
        If not 0, a task is the work between this many inputs and as many others, each read and prepared once.
    searches : int
        If not 0, a task is work items that search the same shards, each read once, for so many batches at most.
    sub_blocks : SubBlocks, optional
        Of a stage with scope "block".
    tables : tuple of TableColumns
        The columns that it adds to tables.
    """

    name: str
    unit: str
    after: tuple[str, ...]
    parameters: tuple[str, ...]
    items: Callable[[Progress], Sequence[WorkItem]]
    run: Callable[[Sequence[Any], Sequence[Any], Any], Artifact]
    scope: Scope
    prepare: Callable[[Artifact], Any] = _as_it_is
    known_after: str = ""
    wanted: Callable[[Config], bool] = _always
    at_most: Callable[[Config], int] = lambda config: config.select.top
    here: bool = False
    bundle: int = 1
    tile: int = 0
    searches: int = 0
    sub_blocks: SubBlocks | None = None
    tables: tuple[TableColumns, ...] = ()

    @property
    def optional(self) -> bool:
        """Whether a configuration can leave it out."""
        return self.wanted is not _always

    def is_due(self, items: Sequence[WorkItem]) -> bool:
        """Whether a run goes through the stage: it skips an optional stage of pairs or parts that has nothing to do."""
        return bool(items) or not (self.optional and self.scope in ("pair", "part"))

    @property
    def counted(self) -> str:
        """What progress counts: shapes, pairs, or nothing."""
        return COUNTED[self.scope]

    def amount(self, item: WorkItem) -> int:
        """How many shapes or pairs a work item of the stage concerns."""
        if self.scope == "block":
            return item.pairs
        return len(item.members) if self.counted == "shapes" else 1

    @property
    def module(self) -> str:
        """The module that defines it."""
        return f"pipeline.stages.{self.name}"

    def recipe(self, config: Config) -> Recipe:
        """The stage's parameters from the configuration, and the digests of its code."""
        parameters = tuple(_read(config, name) for name in self.parameters)
        values = {name: canonical_value(value) for name, value in zip(self.parameters, parameters, strict=True)}
        return Recipe(self.name, parameters, values, code_digests(self.module), library_versions(self.module))


def _read(config: Config, name: str) -> Any:
    value = attrgetter(name)(config)
    # Scores depend on the sigmas only; stages that depend on mode or k name these parameters.
    if isinstance(value, QcrsConfig):
        return value.sigmas
    return value.reading if isinstance(value, ShapeConfig) else value

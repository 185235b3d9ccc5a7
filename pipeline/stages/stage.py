"""What a stage is: its name, the parameters that it reads, how its work is planned and done, what tables show of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Any, Literal

from pipeline.config.schema import Config, QcrsConfig
from pipeline.plan.code_digest import code_digests, library_versions
from pipeline.plan.progress import Progress
from pipeline.plan.sub_block import SubBlock
from pipeline.plan.work_item import Recipe, WorkItem
from pipeline.store.artifact import AnyArray, Artifact
from pipeline.store.keys import canonical_value

Scope = Literal["batch", "block", "collection", "shape", "pair"]
"""What one work item concerns: a batch of shapes, the pairs between two batches (or of a batch and a shard), the whole
collection, one shape, or one pair."""


@dataclass(frozen=True)
class Column:
    """A column of a table; ``kind`` is an Arrow type by name, such as ``int32``, ``float64`` or ``list<int32>``."""

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

    ``values`` gives them, by name, of one of the stage's artifacts. Of a stage of batches these are arrays, lists or
    `Ragged`, an entry for each shape of the batch; an array ``index`` tells of which shape each entry is where there
    are several for one. Of a stage of pairs they are plain values; what is absent is null.
    With ``meaning`` the table is the stage's own.
    """

    table: str
    columns: tuple[Column, ...]
    values: Callable[[Artifact], Mapping[str, Any]]
    meaning: str = ""


@dataclass(frozen=True)
class SubBlocks:
    """How the work of a block is done in pieces, to find what in it hangs or ends its process.

    ``join`` makes of the artifacts of all sub-blocks but the lost ones what the whole would have made. With
    ``columns_are_shapes`` a block lies between two batches; else between a batch and a shard, which is one column.
    """

    join: Callable[[Sequence[Artifact], Sequence[SubBlock]], Artifact]
    columns_are_shapes: bool

    def whole(self, progress: Progress, item: WorkItem) -> SubBlock:
        """All of a work item as a sub-block."""
        a, b = _block(item)
        columns = len(progress.batches[b]) if self.columns_are_shapes else 1
        return SubBlock(item.spec, (0, len(progress.batches[a])), (0, columns))

    def members(self, progress: Progress, item: WorkItem, sub_block: SubBlock) -> list[int]:
        """Positions of the shapes of a sub-block's rows, and of its columns where these are shapes."""
        a, b = _block(item)
        members = {progress.batches[a].start + row for row in range(*sub_block.rows)}
        if self.columns_are_shapes:
            members |= {progress.batches[b].start + column for column in range(*sub_block.columns)}
        return sorted(members)


def _block(item: WorkItem) -> tuple[int, int]:
    assert item.block is not None, "a stage of blocks tells the block of each work item"
    return item.block


def _as_it_is(artifact: Artifact) -> Any:
    return artifact


def _always(config: Config) -> bool:
    return True


@dataclass(frozen=True)
class Stage:
    """One stage of the method, all of it in one file: a module of `pipeline.stages` that defines ``STAGE``.

    Attributes
    ----------
    name : str
        As in keys, tables and messages.
    unit : str
        What its work items are, in the plural.
    after : tuple of str
        Stages that come before it; their order follows from this.
    parameters : tuple of str
        Groups of the configuration, or single parameters, that ``run`` gets and that enter its keys.
    items : callable
        Plans its work items of what is known (`Progress`).
    run : callable
        (inputs, parameters, spec) → artifact. The digest of its code is that of everything that it reaches.
    scope : Scope
        What a work item concerns.
    prepare : callable
        Makes of an artifact what ``run`` gets as an input; once for all work items of a task.
    known_after : str
        The stage whose results tell what there is to do; empty where it is known before anything is computed.
    wanted : callable
        Whether a run with this configuration has the stage.
    at_most : callable
        The greatest number of work items with this configuration, while they are not known.
    here : bool
        Done in the run's own process, because it is not worth a worker.
    bundle : int
        Most work items in one task: a task lasts a second or more, an artifact is as small as can be used again.
    tile : int
        If not 0, a task is the work between so many inputs and so many others, each read and prepared once.
    sub_blocks : SubBlocks, optional
        Of a stage with scope "block".
    tables : tuple of TableColumns
        What the tables show of its artifacts.
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
    sub_blocks: SubBlocks | None = None
    tables: tuple[TableColumns, ...] = ()

    @property
    def optional(self) -> bool:
        """Whether there are runs without it."""
        return self.wanted is not _always

    @property
    def module(self) -> str:
        """The module that defines it; the import closure of its ``run`` is the stage's code."""
        return f"pipeline.stages.{self.name}"

    def recipe(self, config: Config) -> Recipe:
        """Read its parameters out of the configuration and take the digests of its code."""
        parameters = tuple(_read(config, name) for name in self.parameters)
        values = {name: canonical_value(value) for name, value in zip(self.parameters, parameters, strict=True)}
        return Recipe(self.name, parameters, values, code_digests(self.module), library_versions(self.module))


def _read(config: Config, name: str) -> Any:
    value = attrgetter(name)(config)
    # Which pairs are scored is no part of a score: only stages that name mode or k depend on them.
    return value.sigmas if isinstance(value, QcrsConfig) else value

"""What some stages' work items are told beside inputs and parameters: here, so that a plan is made without their code.

All of it enters the items' keys by value.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Place:
    """Where a batch stands to a shard: ``first`` (−1: not in it) numbers its first shape in it; ``after`` the shard."""

    first: int
    after: bool


@dataclass(frozen=True)
class Starts:
    """Of every input of ``pairs`` the positions in the collection of its batch's first shape, and of its shard's."""

    starts: tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class Selecting:
    """What selection knows of the collection: classes by position; where each batch starts; the inputs' batches."""

    classes: tuple[str, ...]
    starts: tuple[int, ...]
    blocks: tuple[tuple[int, int], ...]
    rated: tuple[int, ...]


@dataclass(frozen=True)
class Refined:
    """What the shortlist knows: classes by position, and the pairs (positions), of each of the inputs one."""

    classes: tuple[str, ...]
    pairs: tuple[tuple[int, int], ...]

"""Shards: the trunks of some batches, indexed for the search of partners, a bounded part of a collection (ours)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pipeline.stages.qcrs import prepare
from pipeline.store.artifact import Artifact
from riot.scores.index import TrunkIndex
from riot.scores.qcrs import TrunkStack

__all__ = ["is_shard", "prepare", "run", "unpack"]


def run(inputs: Sequence[TrunkStack], parameters: Sequence[Any], spec: None) -> Artifact:
    """Stacks of batches → their index; its shapes are numbered in the batches' order."""
    return Artifact(TrunkIndex.build(list(inputs)).to_arrays())


def is_shard(artifact: Artifact) -> bool:
    """Whether an artifact is a shard, and not a batch's trunks."""
    return "cells.groups" in artifact.arrays


def unpack(shard: Artifact) -> TrunkIndex:
    """The index that `run` made."""
    return TrunkIndex.from_arrays(shard.arrays)

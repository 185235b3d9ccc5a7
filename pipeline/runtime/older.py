"""Older artifacts of a stage: those that the store has beside the ones that a run asks for."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence
from typing import Any

from pipeline.errors import PayloadError
from pipeline.plan.work_item import WorkItem
from pipeline.store.keys import KeyParts
from pipeline.store.store import Entry, Store


def older_and_missing(store: Store, work: Sequence[WorkItem]) -> tuple[list[str], list[WorkItem]]:
    """Keys of the stage of ``work`` that the store has and the work does not ask for, and the work it lacks."""
    stored = {key for _, key in store.folders(work[0].stage)}
    return sorted(stored - {item.key for item in work}), [item for item in work if item.key not in stored]


def inputs_and_spec(store: Store, key: str, like: KeyParts) -> tuple[Sequence[str], Mapping[str, Any]]:
    """Inputs and spec of an artifact; empty ones if other code or parameters than those of ``like`` made it, or if only
    a part of the work could be done."""
    entry = entry_or_none(store, like.stage, key)
    if entry is not None:
        ours, theirs = like.to_json(), dict(entry.parts)
        spec = theirs["parameters"].get("item")
        apart = {"inputs": (), "parameters": {**ours["parameters"], "item": spec}}
        if isinstance(spec, dict) and {**ours, **apart} == {**theirs, "inputs": ()}:
            return theirs["inputs"], spec
    return (), {}


def entry_or_none(store: Store, stage: str, key: str) -> Entry | None:
    """The manifest of an artifact; None if it is absent or cannot be read."""
    with contextlib.suppress(PayloadError, OSError):
        return store.entry(stage, key)
    return None

"""Accept a run's artifacts for the code that is here, so that an edit that changes no result computes nothing again.

Only the author of the edit can know that no result changes. Every artifact of the run gets a second key, the one that
the code and libraries here give it; its manifest names the first. Keys are chained: stages are accepted in order, and
the keys of inputs are replaced on the way.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from pipeline.explain.causes import explain, gather
from pipeline.plan.code_digest import code_digests, library_versions
from pipeline.stages.all import STAGES
from pipeline.stages.stage import Stage
from pipeline.store.keys import KeyParts
from pipeline.store.store import Entry, State, Store


@dataclass(frozen=True)
class Acceptance:
    """The number of accepted artifacts by stage, and how often each component of a key changed."""

    accepted: Mapping[str, int]
    changes: Mapping[str, int]


def accept(store: Store, keys: Mapping[str, Sequence[str]], *, dry_run: bool = False) -> Acceptance:
    """Give the artifacts of a run, named by ``keys`` by stage, the keys that the code and libraries here give them.

    Raises KeyError if an artifact is gone, `pipeline.errors.PayloadError` if one is damaged. The artifacts before it
    stay accepted, which does no harm; the later ones are not accepted.
    """
    renamed: dict[str, str] = {}
    accepted: Counter[str] = Counter()
    changes: Counter[str] = Counter()
    for stage in STAGES:
        for key in keys.get(stage.name, ()):
            entry = store.entry(stage.name, key)
            if entry is None:
                raise KeyError(f"no artifact {stage.name}/{key}")
            old = parts_of(entry)
            new = _renewed(old, stage, renamed)
            renamed[key] = new.key()
            if stage.name == "ingest":
                renamed |= {alone.key(): _renewed(alone, stage, renamed).key() for alone in old.each_input()}
            if new.key() == key:
                continue
            changes.update(explain(new.to_json(), gather([old.to_json()])))
            if store.state(stage.name, new.key()) is State.PRESENT:
                continue
            payload = store.payload(entry)
            accepted[stage.name] += 1
            if not dry_run:
                store.commit(new, [payload], entry.cost, accepted=key)
    return Acceptance(accepted, changes)


def parts_of(entry: Entry) -> KeyParts:
    """The parts of a stored key."""
    values: Mapping[str, Any] = entry.parts
    return KeyParts(
        entry.stage, values["parameters"], tuple(values["inputs"]), values["code"], values["versions"], values["schema"]
    )


def _renewed(old: KeyParts, stage: Stage, renamed: Mapping[str, str]) -> KeyParts:
    inputs = tuple(renamed.get(key, key) for key in old.inputs)
    return replace(old, inputs=inputs, code=code_digests(stage.module), versions=library_versions(stage.module))

"""Store: content-addressed artifacts in a folder or on an object store; the manifest is the commit.

``<stage>/<kk>/<key>/payload.bin`` is written first, ``manifest.json`` with the payload's digest last, each whole or
not at all (`pipeline.store.filesystem`). Writers do not wait for one another: two of one key write the same payload.
Whatever is torn, truncated or altered is a miss with the reason ``corrupt``, and gets written again. A run looks at
sizes and times of change first (`Store.check_all`); each payload is checked to its last byte when it is read.
"""

from __future__ import annotations

import contextlib
import json
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from pathlib import Path
from typing import Any

from pipeline.errors import PayloadError, SignatureError
from pipeline.store.artifact import Artifact, canonical_json, decode, encode_pieces
from pipeline.store.filesystem.base import Files
from pipeline.store.filesystem.choose import open_files
from pipeline.store.filesystem.local import TEMPORARY as TEMPORARY  # for whoever writes files beside a store
from pipeline.store.filesystem.local import sync_folder as sync_folder
from pipeline.store.filesystem.local import write_atomically as write_atomically
from pipeline.store.keys import SCHEMA, KeyParts, digest_bytes, digest_text
from pipeline.store.location import Location, parse_location
from pipeline.store.signing import Signing
from pipeline.store.storage_errors import writing_to

PAYLOAD = "payload.bin"
MANIFEST = "manifest.json"
KEY = re.compile("[0-9a-f]{64}")

CHECKED_AT_A_TIME = 16
"""Artifacts that one thread checks in a row."""


class State(Enum):
    """What the store knows of a key."""

    PRESENT = "present"
    ABSENT = "absent"
    CORRUPT = "corrupt"
    UNSIGNED = "unsigned"


@dataclass(frozen=True)
class Entry:
    """A committed artifact: its manifest, read but not yet checked against the payload."""

    stage: str
    key: str
    digest: str
    size: int
    parts: Mapping[str, Any]
    cost: Mapping[str, float]


@dataclass(frozen=True)
class Store:
    """Artifacts below one location. Any number of processes may read and write it at once.

    With ``signing`` each artifact is signed as it is written, and only what is signed with that key is read.
    """

    root: Location
    signing: Signing | None = None

    def __reduce__(self) -> tuple[type[Store], tuple[Location, Signing | None]]:
        """For another process, which may have another working folder."""
        return Store, (parse_location(self.text), self.signing)

    @cached_property
    def files(self) -> Files:
        """The files below it; raises `pipeline.errors.StartError` where an object store's client is not installed."""
        return open_files(self.root)

    @property
    def text(self) -> str:
        """Its absolute location as text, which `parse_location` reads in a process with any working folder."""
        return str(self.root.absolute() if isinstance(self.root, Path) else self.root)

    def folder(self, stage: str, key: str) -> Location:
        """The location of a key's artifact, whether it exists or not."""
        return self.root.joinpath(folder_name(stage, key))

    def put(self, parts: KeyParts, artifact: Artifact, cost: Mapping[str, float] | None = None) -> str:
        """Write an artifact under the key of ``parts`` and commit it; returns the key.

        ``cost`` (seconds, cpu_seconds, peak_mb) is kept in the manifest for estimates; it is no part of the payload.
        """
        return self.commit(parts, encode_pieces(artifact), cost or {})

    def commit(
        self,
        parts: KeyParts,
        payload: Sequence[bytes | memoryview],
        cost: Mapping[str, float],
        accepted: str | None = None,
    ) -> str:
        """`put` an artifact encoded in pieces; ``accepted`` is the key of the one that it is a copy of, if it is.

        Raises `pipeline.errors.StorageError` when the location is full or read-only, OSError for other faults.
        """
        key = parts.key()
        manifest = {
            "schema": SCHEMA,
            "stage": parts.stage,
            "key": key,
            "digest": digest_bytes(*payload),
            "bytes": sum(map(len, payload)),
            "parts": parts.to_json(),
            "cost": dict(cost or {}),
        }
        if accepted is not None:
            manifest["accepted"] = accepted
        if self.signing is not None:
            manifest["signature"] = self.signing.sign(canonical_json(manifest))
        written = {PAYLOAD: payload, MANIFEST: [canonical_json(manifest).encode()]}
        with writing_to(self.root):
            self.files.write(folder_name(parts.stage, key), written)
        return key

    def entry(self, stage: str, key: str) -> Entry | None:
        """The manifest of a key; None without one.

        Raises `PayloadError` when it is damaged, `SignatureError` when it is not signed as it should be.
        """
        try:
            raw = self.files.read(f"{folder_name(stage, key)}/{MANIFEST}")
        except FileNotFoundError:
            return None
        try:
            data = json.loads(bytes(raw))
            if data["schema"] != SCHEMA or data["stage"] != stage or data["key"] != key:
                raise PayloadError(f"manifest of {stage}/{key[:12]} names another artifact or schema")
            if digest_text(canonical_json(data["parts"])) != key:
                raise PayloadError(f"manifest of {stage}/{key[:12]} was altered")
            entry = Entry(stage, key, data["digest"], int(data["bytes"]), data["parts"], data["cost"])
            signature = data.pop("signature", None)
        except (ValueError, KeyError, TypeError) as error:
            raise PayloadError(f"manifest of {stage}/{key[:12]} is damaged: {error}") from error
        if self.signing is not None and not self.signing.has_signed(canonical_json(data), signature):
            raise self.signing.error(self.root, [(stage, key)])
        return entry

    def state(self, stage: str, key: str) -> State:
        """Check a key down to the last byte of its payload."""
        return self.check(stage, key)[0]

    def check(self, stage: str, key: str) -> tuple[State, Mapping[str, float]]:
        """The `state` of a key, and what the artifact cost if it is present."""
        try:
            entry = self.entry(stage, key)
            if entry is None:
                return State.ABSENT, {}
            self.payload(entry).release()
            return State.PRESENT, entry.cost
        except SignatureError:
            return State.UNSIGNED, {}
        except (PayloadError, OSError):
            return State.CORRUPT, {}

    def glance(self, stage: str, key: str) -> tuple[State, Mapping[str, float]]:
        """As `check`, but a payload of the right size that is not younger than its manifest counts as whole.

        Whoever alters a payload later makes it younger, so that its bytes are checked. Damage that leaves size and time
        as they were is found when the payload is read, or by `riot cache verify`.
        """
        try:
            entry = self.entry(stage, key)
            if entry is None:
                return State.ABSENT, {}
            stamps = self.files.stamps(folder_name(stage, key))
            size, written = stamps.get(PAYLOAD, (-1, math.inf))
            _, committed = stamps.get(MANIFEST, (-1, -math.inf))
            if size == entry.size and written <= committed:
                return State.PRESENT, entry.cost
        except SignatureError:
            return State.UNSIGNED, {}
        except (PayloadError, OSError):
            return State.CORRUPT, {}
        return self.check(stage, key)

    def check_all(self, references: Sequence[tuple[str, str]]) -> list[tuple[State, Mapping[str, float]]]:
        """`glance` at each of many (stage, key), in order; threads share the work, most of which is waiting.

        Raises `SignatureError` when one is not signed as it should be: computing it again would hide that.
        """
        starts = range(0, len(references), CHECKED_AT_A_TIME)
        rows = [references[start : start + CHECKED_AT_A_TIME] for start in starts]
        with ThreadPoolExecutor(self.files.threads) as threads:
            checked = threads.map(lambda row: [self.glance(*reference) for reference in row], rows)
            states = [state for row in checked for state in row]
        unsigned = [name for name, (state, _) in zip(references, states, strict=True) if state is State.UNSIGNED]
        if unsigned and self.signing is not None:
            raise self.signing.error(self.root, unsigned)
        return states

    def read(self, stage: str, key: str) -> Artifact:
        """`get` for a run: a corrupt artifact is withdrawn, so that the next run makes it again."""
        try:
            return self.get(stage, key)
        except SignatureError:
            raise
        except PayloadError:
            if self.state(stage, key) is State.PRESENT:  # another process has written it meanwhile
                return self.get(stage, key)
            with contextlib.suppress(OSError):  # of a store that cannot be written
                self.files.remove(f"{folder_name(stage, key)}/{MANIFEST}")
            raise

    def get(self, stage: str, key: str) -> Artifact:
        """Read an artifact; the payload is checked, and its arrays are read-only views of the mapped file.

        Raises KeyError when it is absent, `PayloadError` when it is corrupt.
        """
        entry = self.entry(stage, key)
        if entry is None:
            raise KeyError(f"no artifact {stage}/{key} in {self.root}")
        return decode(self.payload(entry))

    def entries(self, stage: str | None = None) -> Iterator[Entry]:
        """All committed artifacts whose manifests can be read, in order of stage and key."""
        for name, key in self.folders(stage):
            with contextlib.suppress(PayloadError):
                entry = self.entry(name, key)
                if entry is not None:
                    yield entry

    def folders(self, stage: str | None = None) -> Iterator[tuple[str, str]]:
        """(stage, key) of every artifact folder, committed or not, sorted."""
        for name in self.files.names("") if stage is None else [stage]:
            for prefix in self.files.names(name):
                for key in self.files.names(f"{name}/{prefix}"):
                    # Only what `put` makes: a wrong folder that somebody tidies by mistake must seem empty.
                    if KEY.fullmatch(key) and key[:2] == prefix:
                        yield name, key

    def payload(self, entry: Entry) -> memoryview:
        """The bytes of a committed artifact; raises `PayloadError` when they are not what its manifest says."""
        name = f"{entry.stage}/{entry.key[:12]}"
        try:
            view = self.files.read(f"{folder_name(entry.stage, entry.key)}/{PAYLOAD}")
        except FileNotFoundError as error:
            raise PayloadError(f"{name}: the payload is missing") from error
        if len(view) != entry.size:
            raise PayloadError(f"{name}: {len(view)} bytes, {entry.size} expected")
        if digest_bytes(view) != entry.digest:
            raise PayloadError(f"{name}: the payload was altered")
        return view


def folder_name(stage: str, key: str) -> str:
    """The folder of an artifact, relative to the store's location."""
    return f"{stage}/{key[:2]}/{key}"

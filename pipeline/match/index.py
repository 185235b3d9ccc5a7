"""The index over a collection's trunks, kept in the store: built once, then loaded.

Every array is an artifact of its own, named after the trunks that it was built of, so that several are checked at a
time: most of loading is hashing. No run stands on them; whoever deletes them pays for building them again.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor

from pipeline.errors import PayloadError
from pipeline.plan.code_digest import code_digests, library_versions
from pipeline.stages.qcrs import prepare
from pipeline.store.artifact import AnyArray, Artifact
from pipeline.store.keys import KeyParts
from pipeline.store.store import Store
from riot.scores.index import TrunkIndex

STAGE, TRUNKS = "index", "trunks"
READERS = 4
"""Threads that read and check the arrays."""


def load_index(store: Store, trunks: Sequence[str], note: Callable[[str], None]) -> TrunkIndex:
    """The index over the artifacts of trunks with these keys, in order, of every item of their batches.

    It is built and saved when the store has none or a damaged one; ``note`` is told so. Raises KeyError or
    `PayloadError` when it has to be built and trunks are absent or corrupt.
    """
    parts = _parts(trunks)
    saved = _read(store, parts)
    if saved is not None:
        return saved
    note("building the index, once for this collection …")
    index = TrunkIndex.build([prepare(store.get(TRUNKS, key)) for key in trunks])
    try:
        _save(store, parts, index)
    except OSError as error:
        note(f"the index could not be saved, and will be built again next time: {error}")
    return index


def _save(store: Store, parts: Mapping[str, KeyParts], index: TrunkIndex) -> None:
    for name, array in index.to_arrays().items():
        store.put(parts[name], Artifact({name: array}))


def _read(store: Store, parts: Mapping[str, KeyParts]) -> TrunkIndex | None:
    def read(name: str) -> AnyArray:
        return store.get(STAGE, parts[name].key()).arrays[name]

    try:
        with ThreadPoolExecutor(READERS) as threads:
            return TrunkIndex.from_arrays(dict(zip(parts, threads.map(read, parts), strict=True)))
    except (KeyError, PayloadError, OSError):
        return None


def _parts(trunks: Sequence[str]) -> dict[str, KeyParts]:
    code, versions = code_digests(__name__), library_versions(__name__)
    names = TrunkIndex.array_names()
    return {name: KeyParts(STAGE, {"array": name}, tuple(trunks), code, versions) for name in names}

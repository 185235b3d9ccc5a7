"""The index over a collection's trunks, kept in the store: built once, then loaded.

Each array of the index is an artifact of its own, keyed by the trunks that it was built from: loading is mostly
hashing, and so several arrays are hashed at a time. No run depends on them; a deleted one is built again.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor

from pipeline.errors import PayloadError
from pipeline.plan.code_digest import code_digests, library_versions
from pipeline.stages.qcrs import stack_of_batch
from pipeline.store.artifact import AnyArray, Artifact
from pipeline.store.keys import KeyParts
from pipeline.store.store import Store
from riot.scores.index import TrunkIndex

INDEX_STAGE, TRUNKS_STAGE = "index", "trunks"
READERS = 4
"""Threads that read and check the arrays."""


def load_index(store: Store, trunks: Sequence[str], note: Callable[[str], None]) -> TrunkIndex:
    """The index over the artifacts of trunks with these keys, in order, of every item of their batches.

    If the store has none, or a damaged one, the index is built and saved, and ``note`` gets a message. Raises KeyError
    or `PayloadError` if it must be built and trunks are absent or corrupt.
    """
    array_keys = _array_keys(trunks)
    saved = _read(store, array_keys)
    if saved is not None:
        return saved
    note("building the index, once for this collection …")
    index = TrunkIndex.build([stack_of_batch(store.get(TRUNKS_STAGE, key)) for key in trunks])
    try:
        _save(store, array_keys, index)
    except OSError as error:
        note(f"the index could not be saved, and will be built again next time: {error}")
    return index


def _save(store: Store, array_keys: Mapping[str, KeyParts], index: TrunkIndex) -> None:
    for name, array in index.to_arrays().items():
        store.put(array_keys[name], Artifact({name: array}))


def _read(store: Store, array_keys: Mapping[str, KeyParts]) -> TrunkIndex | None:
    def read(name: str) -> AnyArray:
        return store.get(INDEX_STAGE, array_keys[name].key()).arrays[name]

    try:
        with ThreadPoolExecutor(READERS) as threads:
            return TrunkIndex.from_arrays(dict(zip(array_keys, threads.map(read, array_keys), strict=True)))
    except (KeyError, PayloadError, OSError):
        return None


def _array_keys(trunks: Sequence[str]) -> dict[str, KeyParts]:
    code, versions = code_digests(__name__), library_versions(__name__)
    names = TrunkIndex.array_names()
    return {name: KeyParts(INDEX_STAGE, {"array": name}, tuple(trunks), code, versions) for name in names}

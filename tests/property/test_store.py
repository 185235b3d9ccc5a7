"""Artifacts and the store: what was put comes back to the last bit, and damage is a miss, never an answer."""

from __future__ import annotations

import os
import struct
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst

from pipeline.errors import PayloadError
from pipeline.store.artifact import ALIGNMENT, MAGIC, Artifact, canonical_json, decode, encode
from pipeline.store.filesystem.local import MAPPED_SIZE
from pipeline.store.keys import KeyParts
from pipeline.store.store import CHECKED_AT_A_TIME, MANIFEST, PAYLOAD, TEMPORARY, State, Store

names = st.text(alphabet="abcdefg_", min_size=1, max_size=6)
values = npst.arrays(
    dtype=st.sampled_from([np.float64, np.int64, np.int32, np.int8, np.bool_]),
    shape=npst.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=4),
)
documents = st.dictionaries(names, st.none() | st.integers(-9, 9) | st.floats(allow_nan=False) | st.text(max_size=5))
artifacts = st.builds(Artifact, st.dictionaries(names, values, max_size=4), documents)


def parts(name: str = "a") -> KeyParts:
    return KeyParts("stage", {"name": name}, (), {}, {})


def example() -> Artifact:
    return Artifact({"x": np.arange(100.0), "n": np.array([], dtype=np.int8)}, {"errors": [], "text": "å"})


@pytest.fixture
def store(tmp_path: Path) -> Store:
    return Store(tmp_path / "store")


@settings(max_examples=60)
@given(artifacts)
def test_payloads_come_back_exactly(artifact: Artifact) -> None:
    payload = encode(artifact)
    again = decode(payload)
    assert again.document == artifact.document
    assert again.arrays.keys() == artifact.arrays.keys()
    for name, array in artifact.arrays.items():
        assert again.arrays[name].dtype == array.dtype and again.arrays[name].shape == array.shape
        assert again.arrays[name].tobytes() == np.ascontiguousarray(array).tobytes()
    backwards = Artifact(dict(reversed(list(artifact.arrays.items()))), artifact.document)
    assert encode(backwards) == payload


@settings(max_examples=60)
@given(artifacts, st.data())
def test_a_cut_payload_is_refused_or_whole_in_what_it_holds(artifact: Artifact, data: st.DataObject) -> None:
    payload = encode(artifact)
    cut = payload[: data.draw(st.integers(0, len(payload) - 1))]
    try:
        again = decode(cut)
    except PayloadError:
        return
    assert all(again.arrays[name].tobytes() == array.tobytes() for name, array in artifact.arrays.items())


def test_an_array_of_objects_is_refused() -> None:
    with pytest.raises(PayloadError, match="numbers"):
        encode(Artifact({"x": np.array(["text"])}))


def test_put_get(store: Store) -> None:
    key = store.put(parts(), example(), {"seconds": 2.5})
    assert key == parts().key()
    assert store.state("stage", key) is State.PRESENT
    again = store.get("stage", key)
    assert np.array_equal(again.arrays["x"], example().arrays["x"]) and again.document["text"] == "å"
    with pytest.raises(ValueError):
        again.arrays["x"][0] = 1.0
    entry = store.entry("stage", key)
    assert entry is not None and entry.cost["seconds"] == 2.5 and entry.parts == parts().to_json()


def test_an_absent_key_is_absent(store: Store) -> None:
    assert store.state("stage", parts().key()) is State.ABSENT
    with pytest.raises(KeyError):
        store.get("stage", parts().key())


def damage(store: Store, kind: str) -> None:
    folder = store.folder("stage", parts().key())
    payload, manifest = folder / PAYLOAD, folder / MANIFEST
    raw = payload.read_bytes()
    if kind == "truncated":
        payload.write_bytes(raw[:-5])
    elif kind == "altered":
        payload.write_bytes(raw[:-1] + bytes([raw[-1] ^ 1]))
    elif kind == "longer":
        payload.write_bytes(raw + b"\0")
    elif kind == "empty":
        payload.write_bytes(b"")
    elif kind == "missing":
        payload.unlink()
    elif kind == "torn manifest":
        manifest.write_bytes(manifest.read_bytes()[:20])
    elif kind == "foreign manifest":
        other = Store(store.root.parent / "other")
        key = other.put(parts("b"), example())
        manifest.write_bytes((other.folder("stage", key) / MANIFEST).read_bytes())


@pytest.mark.parametrize(
    "kind", ["truncated", "altered", "longer", "empty", "missing", "torn manifest", "foreign manifest"]
)
def test_damage_is_corrupt_and_mended_by_the_next_put(store: Store, kind: str) -> None:
    key = store.put(parts(), example())
    damage(store, kind)
    assert store.state("stage", key) is State.CORRUPT
    with pytest.raises(PayloadError):
        store.get("stage", key)
    store.put(parts(), example())
    assert store.state("stage", key) is State.PRESENT


def test_many_are_checked_as_each_alone(store: Store) -> None:
    keys = [store.put(parts(str(number)), example(), {"seconds": number}) for number in range(3 * CHECKED_AT_A_TIME)]
    (store.folder("stage", keys[1]) / PAYLOAD).write_bytes(b"")
    references = [("stage", key) for key in [*keys, "0" * 64]]
    found = store.check_all(references)
    assert [state for state, _ in found] == [store.state(*reference) for reference in references]
    assert [found[0], found[2]] == [(State.PRESENT, {"seconds": 0}), (State.PRESENT, {"seconds": 2})]
    assert found[1] == (State.CORRUPT, {}) and found[-1] == (State.ABSENT, {})


def test_large_payloads_are_mapped_and_come_back_too(store: Store) -> None:
    large = Artifact({"x": np.arange(MAPPED_SIZE / 8)})
    key = store.put(parts(), large)
    again = store.get("stage", key).arrays["x"]
    assert np.array_equal(again, large.arrays["x"]) and not again.flags.writeable
    damage(store, "altered")
    assert store.state("stage", key) is State.CORRUPT


def test_a_payload_without_its_manifest_is_not_committed(store: Store) -> None:
    key = store.put(parts(), example())
    (store.folder("stage", key) / MANIFEST).unlink()
    assert store.state("stage", key) is State.ABSENT


def test_writers_of_one_key_agree(store: Store) -> None:
    writers = [threading.Thread(target=store.put, args=(parts(), example())) for _ in range(8)]
    for writer in writers:
        writer.start()
    for writer in writers:
        writer.join()
    folder = store.folder("stage", parts().key())
    assert store.state("stage", parts().key()) is State.PRESENT
    assert (folder / PAYLOAD).read_bytes() == encode(example())
    assert not list(folder.glob(f"{TEMPORARY}*"))


def test_a_failed_write_leaves_nothing(store: Store) -> None:
    with pytest.raises(PayloadError):
        store.put(parts(), Artifact({"x": np.array([None])}))
    assert store.state("stage", parts().key()) is State.ABSENT
    assert not list(store.root.rglob(f"{TEMPORARY}*"))


def in_the_past(store: Store, key: str) -> None:
    """Make both files of an artifact an hour older."""
    for path in (store.folder("stage", key) / PAYLOAD, store.folder("stage", key) / MANIFEST):
        os.utime(path, (path.stat().st_mtime - 3600,) * 2)


def test_a_glance_reads_no_payload_that_is_older_than_its_manifest(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    key = store.put(parts(), example(), {"seconds": 1.0})
    in_the_past(store, key)
    monkeypatch.setattr(Store, "payload", lambda *_: pytest.fail("a payload was read"))
    assert store.glance("stage", key) == (State.PRESENT, {"seconds": 1.0})


@pytest.mark.parametrize("kind", ["truncated", "altered", "longer", "empty", "missing", "torn manifest"])
def test_a_glance_finds_what_was_damaged_later(store: Store, kind: str) -> None:
    key = store.put(parts(), example())
    in_the_past(store, key)
    damage(store, kind)
    assert store.glance("stage", key)[0] is State.CORRUPT


def test_damage_that_keeps_the_time_is_found_by_reading_and_then_made_again(store: Store) -> None:
    key = store.put(parts(), example())
    payload = store.folder("stage", key) / PAYLOAD
    before = payload.stat().st_mtime
    damage(store, "altered")
    os.utime(payload, (before, before))
    assert store.glance("stage", key)[0] is State.PRESENT and store.state("stage", key) is State.CORRUPT
    with pytest.raises(PayloadError):
        store.read("stage", key)
    assert store.glance("stage", key)[0] is State.ABSENT


DEEP = b"[" * 100_000


@pytest.mark.parametrize(
    "entry",
    [
        {"offset": -64},
        {"bytes": -8},
        {"offset": 64},
        {"offset": 0.0},
        {"shape": [-1]},
        {"shape": [10**30]},
        {"dtype": "|V8"},
        {"dtype": "|O"},
        {"dtype": "<M8[s]"},
        {"dtype": "<U2"},
    ],
    ids=str,
)
def test_a_header_that_lies_is_no_artifact(entry: dict[str, Any]) -> None:
    good = {"name": "x", "dtype": "<f8", "shape": [1], "offset": 0, "bytes": 8}
    for change, refused in (({}, False), (entry, True)):
        header = canonical_json({"arrays": [{**good, **change}], "document": {}}).encode()
        payload = MAGIC + struct.pack("<Q", len(header)) + header
        payload += bytes(-len(payload) % ALIGNMENT + 8)
        if refused:
            with pytest.raises(PayloadError):
                decode(payload)
        else:
            assert decode(payload).arrays["x"].tolist() == [0.0]


def test_a_deep_header_is_no_artifact() -> None:
    with pytest.raises(PayloadError):
        decode(MAGIC + struct.pack("<Q", len(DEEP)) + DEEP)

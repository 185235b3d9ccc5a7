"""What every file system of a store must do: inherit `FilesKit` and give it a fixture ``files``."""

from __future__ import annotations

import threading

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    invariant,
    precondition,
    rule,
    run_state_machine_as_test,
)

from pipeline.errors import PayloadError
from pipeline.store.artifact import Artifact
from pipeline.store.filesystem.base import Files
from pipeline.store.keys import KeyParts
from pipeline.store.store import MANIFEST, PAYLOAD, State, Store, folder_name

names = st.sampled_from(["a", "b", "c", "long-name_1.bin"])
folders = st.sampled_from(["x", "x/y", "x/y/z", "w"])
contents = st.binary(max_size=40) | st.just(bytes(range(256)) * 2048)


def parts(number: int) -> KeyParts:
    return KeyParts("stage", {"number": number}, (), {}, {})


def made(number: int) -> Artifact:
    return Artifact({"x": np.arange(number * 50.0)}, {"number": number})


class Model(RuleBasedStateMachine):
    """A store beside a dictionary of what it should hold: put, get, damage, lose, remove, in any order."""

    files: Files

    @initialize()
    def begin(self) -> None:
        for name in list(self.files.names("")):
            self.files.remove(name)
        self.store = Store(self.files.location)
        self.expected: dict[int, State] = {}

    @rule(number=st.integers(0, 3))
    def put(self, number: int) -> None:
        assert self.store.put(parts(number), made(number), {"seconds": 1.0}) == parts(number).key()
        self.expected[number] = State.PRESENT

    @precondition(lambda self: self.expected)
    @rule(data=st.data(), name=st.sampled_from([PAYLOAD, MANIFEST]))
    def cut(self, data: st.DataObject, name: str) -> None:
        number = data.draw(st.sampled_from(sorted(self.expected)))
        folder = folder_name("stage", parts(number).key())
        if name not in self.files.sizes(folder):
            return
        raw = bytes(self.files.read(f"{folder}/{name}"))
        self.files.write(folder, {name: raw[: data.draw(st.integers(0, max(0, len(raw) - 1)))]})
        self.expected[number] = State.CORRUPT if MANIFEST in self.files.sizes(folder) else State.ABSENT

    @precondition(lambda self: self.expected)
    @rule(data=st.data(), name=st.sampled_from([PAYLOAD, MANIFEST]))
    def lose(self, data: st.DataObject, name: str) -> None:
        """A crash between payload and manifest, or a file that was removed."""
        number = data.draw(st.sampled_from(sorted(self.expected)))
        folder = folder_name("stage", parts(number).key())
        self.files.remove(f"{folder}/{name}")
        self.expected[number] = State.CORRUPT if MANIFEST in self.files.sizes(folder) else State.ABSENT

    @precondition(lambda self: self.expected)
    @rule(data=st.data())
    def remove(self, data: st.DataObject) -> None:
        number = data.draw(st.sampled_from(sorted(self.expected)))
        self.files.remove(folder_name("stage", parts(number).key()))
        self.expected[number] = State.ABSENT

    @invariant()
    def it_is_as_expected(self) -> None:
        if not hasattr(self, "store"):
            return
        for number, state in self.expected.items():
            key = parts(number).key()
            assert self.store.state("stage", key) is state
            if state is State.PRESENT:
                found = self.store.get("stage", key)
                assert np.array_equal(found.arrays["x"], made(number).arrays["x"])
                assert found.document == {"number": number}
            else:
                with pytest.raises(KeyError if state is State.ABSENT else PayloadError):
                    self.store.get("stage", key)
        present = {number for number, state in self.expected.items() if state is State.PRESENT}
        whole = {key for stage, key in self.store.folders() if self.store.state(stage, key) is State.PRESENT}
        assert whole == {parts(number).key() for number in present}


class FilesKit:
    """The tests; ``files`` is a fixture with an empty location for each test."""

    examples = 25

    def test_what_is_written_comes_back(self, files: Files) -> None:
        @settings(max_examples=self.examples, suppress_health_check=list(HealthCheck))
        @given(folders, st.dictionaries(names, contents, min_size=1))
        def check(folder: str, written: dict[str, bytes]) -> None:
            files.remove(folder)
            files.write(folder, written)
            assert {name: bytes(files.read(f"{folder}/{name}")) for name in written} == written
            assert files.sizes(folder) == {name: len(data) for name, data in written.items()}
            assert [name for name in files.names(folder) if name in written] == sorted(written)

        check()

    def test_what_is_not_there_is_said(self, files: Files) -> None:
        for name in ("nothing", "no/thing", "no/thing/at/all"):
            with pytest.raises(FileNotFoundError):
                files.read(name)
            assert list(files.names(name)) == [] and files.sizes(name) == {} and files.abandoned(name) == []
            files.remove(name)

    def test_below_a_file_there_is_nothing(self, files: Files) -> None:
        files.write("folder", {"file": b"1"})
        with pytest.raises(FileNotFoundError):
            files.read("folder/file/deeper")
        assert list(files.names("folder/file")) == []

    def test_writing_again_replaces(self, files: Files) -> None:
        files.write("f", {"a": b"long before", "b": b"stays"})
        held = files.read("f/a")
        files.write("f", {"a": b"new"})
        assert bytes(held) == b"long before" and bytes(files.read("f/a")) == b"new"
        assert bytes(files.read("f/b")) == b"stays"

    def test_removing_takes_all_below_and_nothing_beside(self, files: Files) -> None:
        files.write("a", {"1": b"1"})
        files.write("a/b", {"2": b"2"})
        files.write("ab", {"3": b"3"})
        files.remove("a/1")
        assert list(files.names("a")) == ["b"]
        files.remove("a")
        assert list(files.names("")) == ["ab"]

    def test_a_probe_leaves_nothing(self, files: Files) -> None:
        files.probe()
        assert list(files.names("")) == []

    def test_listings_of_many_pages(self, files: Files) -> None:
        keys = [parts(number).key() for number in range(30)]
        for number in range(30):
            Store(files.location).put(parts(number), made(0))
        assert list(Store(files.location).folders()) == sorted(("stage", key) for key in keys)

    def test_writers_of_one_key_agree(self, files: Files) -> None:
        store = Store(files.location)
        writers = [threading.Thread(target=store.put, args=(parts(1), made(1))) for _ in range(6)]
        for writer in writers:
            writer.start()
        for writer in writers:
            writer.join()
        assert store.state("stage", parts(1).key()) is State.PRESENT
        assert sorted(files.sizes(folder_name("stage", parts(1).key()))) == [MANIFEST, PAYLOAD]

    def test_a_store_is_a_dictionary_that_tells_damage(self, files: Files) -> None:
        machine = type("Machine", (Model,), {"files": files})
        run_state_machine_as_test(
            machine,
            settings=settings(
                max_examples=self.examples,
                stateful_step_count=12,
                suppress_health_check=list(HealthCheck),
            ),
        )

"""The history of a piece of work and its folder, without a browser and without geometry."""

from __future__ import annotations

import stat
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec import structs

from riot.errors import FormatError
from studio.messages import EditRequest, Pull, RequestError, read_request
from studio.session.folder import SessionFolder, new_folder, newest
from studio.session.history import History
from studio.session.state import Pin, State


@given(st.lists(st.sampled_from(["step", "undo", "redo", "snapshot", "restore"])))
def test_history_is_a_line_with_a_present(moves: list[str]) -> None:
    """Against a plain list and an index: steps cut off what was undone, nothing else is lost."""
    history, states, at = History(), [State()], 0
    kept: State | None = None
    for number, move in enumerate(moves):
        if move == "step":
            state = State(f"step {number}")
            history, states = history.step(state), [*states[: at + 1], state]
            at += 1
        elif move == "undo":
            history, at = history.undone(), max(0, at - 1)
        elif move == "redo":
            history, at = history.redone(), min(len(states) - 1, at + 1)
        elif move == "snapshot":
            history, kept = history.snapshot("one"), states[at]
        elif kept is not None:
            history = history.restored("one")
            states = [*states[: at + 1], structs.replace(kept, step="restore one")]
            at += 1
        assert list(history.states) == states
        assert history.now == states[at]
        assert (history.undo is None) == (at == 0)
        assert (history.redo is None) == (at == len(states) - 1)


def test_what_a_search_finds_completes_the_step_that_asked_also_after_undo() -> None:
    asked = State("choose bat", p="a" * 32, q="b" * 32)
    history = History().step(asked).snapshot("early").undone()
    after = history.settled(asked, structs.replace(asked, shown="c" * 32))
    assert after.now == State()
    assert after.redone().now.shown == "c" * 32
    assert dict(after.snapshots)["early"].shown == "c" * 32


def test_a_folder_gives_back_what_was_saved_and_only_its_owner_reads_it(tmp_path: Path) -> None:
    folder = new_folder(tmp_path / "sessions")
    pinned = State("pull", pins_p=(Pin("draw", (0.1, 0.2, 0.30000000000000004, 1e-17)),), weight=None)
    history = History().step(pinned).snapshot("best").step(State("keep")).undone()
    folder.save(history)
    assert SessionFolder(folder.path).load() == history
    assert newest(tmp_path / "sessions")[0].name == folder.name
    for path in (folder.path, *folder.path.rglob("*")):
        assert stat.S_IMODE(path.stat().st_mode) == (0o700 if path.is_dir() else 0o600), path


def test_a_thousand_steps_are_saved_one_at_a_time(tmp_path: Path) -> None:
    folder, history = new_folder(tmp_path), History()
    for number in range(20):
        history = history.step(State(f"step {number}"))
        folder.save(history)
    assert len(list((folder.path / "states").iterdir())) == 21
    assert SessionFolder(folder.path).load().undone().now.step == "step 18"


def test_a_damaged_session_is_told_by_its_path(tmp_path: Path) -> None:
    folder = new_folder(tmp_path)
    folder.save(History().step(State("pull")))
    for path in (folder.path / "states").iterdir():
        path.write_text("{")
    with pytest.raises(FormatError, match=folder.name):
        SessionFolder(folder.path).load()


@pytest.mark.parametrize("name", ["../../etc/passwd", "a/b", "", "A" * 32, "a" * 31, "a" * 32 + "\n"])
def test_names_from_outside_open_nothing(tmp_path: Path, name: str) -> None:
    with pytest.raises(KeyError):
        new_folder(tmp_path).transform(name)


def test_requests_are_read_as_typed() -> None:
    text = '{"type":"edit","seq":7,"phase":"move","edit":{"kind":"pull","side":"p","at":[0,1],"to":[1,2]}}'
    assert read_request(text) == EditRequest(7, "move", Pull("p", (0.0, 1.0), (1.0, 2.0)))


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        '{"type":"undo"}',
        '{"type":"undo","seq":-1}',
        '{"type":"rm","seq":1}',
        '{"type":"edit","seq":1,"phase":"move","edit":{"kind":"weight","weight":1e9}}',
        '{"type":"edit","seq":1,"phase":"move","edit":{"kind":"pull","side":"r","at":[0,1],"to":[1,2]}}',
        '{"type":"edit","seq":1,"phase":"move","edit":{"kind":"pull","side":"p","at":[0],"to":[1,2]}}',
        '{"type":"undo","seq":1,"path":"/etc/passwd"}',
        "[" * 100_000,
    ],
)
def test_other_requests_are_refused(text: str) -> None:
    with pytest.raises(RequestError, match="not understood"):
        read_request(text)

"""What a run says as it runs, on a terminal and elsewhere."""

from __future__ import annotations

import io
import threading
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console

from pipeline.cli import progress
from pipeline.cli.progress import Advance, show_progress, stage_line
from pipeline.runtime.events import Event, ItemDone, KernelsAwaited, Note, StageEnded, StageStarted
from riot.kernels.compiling.waiting import Waiting

ENDED = StageEnded("trunks", 7, 2, 3, 1, 1, 0.5, 0.5, 0.5, 10.0, "shapes", 224, 64)
HOSTILE = ("[red]x[/red].png", "[/]", "a:cat:b", "[link=file:///etc]y[/link]", "back\\[slash]", "[bold", "café ]] [[")


@pytest.mark.parametrize("terminal", [False, True])
@pytest.mark.parametrize("name", HOSTILE)
def test_a_note_is_said_as_it_is(name: str, terminal: bool) -> None:
    out = io.StringIO()
    with show_progress(Console(file=out, force_terminal=terminal, width=140)) as listen:
        listen(Note(f"set aside: {name}"))
    assert f"set aside: {name}" in out.getvalue()


def said(*events: Event) -> list[str]:
    out = io.StringIO()
    with show_progress(Console(file=out, width=140)) as listen:
        for event in events:
            listen(event)
    return out.getvalue().splitlines()


def test_stages_are_said_when_they_are_over() -> None:
    done = [ItemDone("trunks", failed, 32) for failed in (False, False, True)]
    damaged, line = said(StageStarted("trunks", "batches", 7, 2, 1, "shapes", 160), *done, ENDED)
    assert damaged.startswith("trunks: 1 damaged in the store")
    assert (
        line == stage_line(ENDED) == "trunks         224 shapes, 64 of them in the store, 1 failed, 1 blocked in 0.5 s"
    )


@pytest.mark.parametrize(
    ("counts", "words"),
    [
        ({"total": 2, "computed": 2, "counted": "shapes", "amount": 40}, "40 shapes in 0.5 s"),
        ({"total": 2, "cached": 2, "counted": "pairs", "amount": 4950}, "4,950 pairs, in the store"),
        ({"total": 1, "computed": 1}, "done in 0.5 s"),
        ({"total": 0}, "nothing to do"),
    ],
)
def test_lines_count_shapes_and_pairs(counts: dict[str, Any], words: str) -> None:
    nought = dict.fromkeys(("cached", "computed", "failed", "blocked"), 0)
    costs = {"seconds": 0.5, "cpu_seconds": 0.5, "stored_seconds": 0.5, "peak_mb": 1.0}
    assert stage_line(StageEnded("stage", **{**nought, **costs, **counts})) == f"{'stage':<14} {words}"


@given(st.integers(1, 10_000), st.floats(0.1, 1e4), st.data())
def test_what_remains_falls_as_more_is_done_in_the_same_time(total: int, seconds: float, data: st.DataObject) -> None:
    less = data.draw(st.integers(1, total))
    more = data.draw(st.integers(less, total))
    slow, fast = (Advance("stage", total, "shapes", 0.0, done) for done in (less, more))
    remaining, sooner = slow.remaining(seconds), fast.remaining(seconds)
    assert remaining is not None and sooner is not None and 0.0 <= sooner <= remaining
    assert Advance("stage", total, "shapes", 0.0, total).remaining(seconds) == 0.0
    assert Advance("stage", total, "shapes", 0.0).remaining(seconds) is None


def test_without_a_terminal_a_stage_is_said_every_few_seconds(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(progress, "SECONDS_BETWEEN_LINES", 0.01)
    lines = io.StringIO()
    is_said = threading.Event()
    write = lines.write

    def write_and_tell(text: str) -> int:
        if "32 of 160 shapes" in text:
            is_said.set()
        return write(text)

    monkeypatch.setattr(lines, "write", write_and_tell, raising=False)
    with show_progress(Console(file=lines, width=140)) as listen:
        listen(StageStarted("trunks", "batches", 5, 0, 0, "shapes", 160))
        listen(ItemDone("trunks", False, 32))
        assert is_said.wait(timeout=60)


def test_kernels_are_counted_while_a_stage_waits_for_them() -> None:
    out = io.StringIO()
    with show_progress(Console(file=out, force_terminal=True, width=100)) as listen:
        listen(StageStarted("trunks", "batches", 5, 0, 0, "shapes", 160))
        listen(KernelsAwaited("trunks", Waiting(3, 5, 11.7)))
    assert "kernels" in out.getvalue() and "3 of 5 modules compiled, about 12 s left" in out.getvalue()

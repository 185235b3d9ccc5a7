"""What a run says as it runs, on a terminal and elsewhere."""

from __future__ import annotations

import io

import pytest
from rich.console import Console

from pipeline.cli.progress import show_progress, stage_line
from pipeline.runtime.events import ItemDone, Note, StageEnded, StageStarted

ENDED = StageEnded("trunks", 7, 2, 3, 1, 1, 0.5, 0.5, 0.5, 10.0)
HOSTILE = ("[red]x[/red].png", "[/]", "a:cat:b", "[link=file:///etc]y[/link]", "back\\[slash]", "[bold", "café ]] [[")


@pytest.mark.parametrize("terminal", [False, True])
@pytest.mark.parametrize("name", HOSTILE)
def test_a_note_is_said_as_it_is(name: str, terminal: bool) -> None:
    out = io.StringIO()
    with show_progress(Console(file=out, force_terminal=terminal, width=140)) as listen:
        listen(Note(f"set aside: {name}"))
    assert f"set aside: {name}" in out.getvalue()


def test_stages_are_said_when_they_are_over() -> None:
    out = io.StringIO()
    with show_progress(Console(file=out, width=140)) as listen:
        listen(StageStarted("trunks", "batch", 7, 2, 1))
        for failed in (False, False, True):
            listen(ItemDone("trunks", failed))
        listen(ENDED)
    damaged, line = out.getvalue().splitlines()
    assert damaged.startswith("trunks: 1 damaged in the store")
    assert line == stage_line(ENDED) == "trunks         2 cached, 3 computed, 1 failed, 1 blocked in 0.5 s"

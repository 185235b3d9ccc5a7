"""What a run says about counts that could surprise."""

from __future__ import annotations

import pytest

from pipeline.tables.messages import sentences, several

USUAL = {"shapes": 9, "classes": 3, "selected": 2, "without_trunks": 0, "ignored_files": 0, "blocked": 0}


def test_a_usual_run_needs_no_words() -> None:
    assert sentences(USUAL, "global") == []
    assert sentences({}, "") == []


@pytest.mark.parametrize(
    ("changes", "policy", "words"),
    [
        ({"without_trunks": 1}, "global", "1 shape has no trunk, so that every QCRS with it is 0"),
        ({"without_trunks": 1200}, "global", "1,200 shapes have no trunk, so that every QCRS with them is 0"),
        ({"selected": 0}, "global", "no two shapes that may be paired have a QCRS above 0"),
        ({"selected": 0, "classes": 1}, "global", "shapes of different classes"),
        ({"selected": 0, "classes": 1}, "paper", "one shape of each class"),
        ({"selected": 0, "shapes": 1, "classes": 1}, "global", "there is 1"),
        ({"selected": 0, "shapes": 0, "classes": 0}, "global", "there are none"),
        ({"ignored_files": 2}, "global", "2 files were ignored"),
    ],
)
def test_what_could_surprise_is_said_once(changes: dict[str, int], policy: str, words: str) -> None:
    (sentence,) = sentences(USUAL | changes, policy)
    assert words in sentence


def test_failures_speak_for_themselves() -> None:
    assert sentences(USUAL | {"selected": 0, "blocked": 4}, "global") == []


def test_nouns_follow_their_number() -> None:
    assert [several(n, "class", "classes") for n in (0, 1, 2)] == ["0 classes", "1 class", "2 classes"]
    assert several(1000, "error") == "1,000 errors"

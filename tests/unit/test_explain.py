"""Explanations: the component of the key that changed, old and new."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from pipeline.explain.causes import NOT_DONE, Causes, explain, gather
from pipeline.plan.work_item import WorkItem
from pipeline.store.artifact import Artifact
from pipeline.store.keys import KeyParts
from pipeline.store.store import PAYLOAD, Store


def parts(**changes: Any) -> KeyParts:
    values = {
        "stage": "crs",
        "parameters": {"crs": {"lines": 128, "sigma_e": 0.1}},
        "inputs": ("a", "b"),
        "code": {"riot.scores.crs": "aaaaaaaaaaaa"},
        "versions": {"numpy": "2.0"},
    }
    return KeyParts(**{**values, **changes})


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"parameters": {"crs": {"lines": 64, "sigma_e": 0.1}}}, "parameters.crs.lines 128 → 64"),
        ({"code": {"riot.scores.crs": "bbbbbbbbbbbb"}}, "code.riot.scores.crs aaaaaaaa → bbbbbbbb"),
        ({"code": {"riot.scores.crs": "aaaaaaaaaaaa", "riot.new": "cccccccccccc"}}, "code.riot.new absent → cccccccc"),
        ({"versions": {"numpy": "2.1"}}, "versions.numpy '2.0' → '2.1'"),
        ({"inputs": ("a", "c")}, "inputs: 1 of 2 are new"),
        ({"inputs": ("b", "a")}, "inputs: known ones in a combination that is not done yet, or under other names"),
        ({"schema": 2}, "schema 1 → 2"),
    ],
)
def test_what_changed_is_named(changes: dict[str, Any], words: str) -> None:
    assert explain(parts(**changes).to_json(), gather([parts().to_json()])) == (words,)


def test_the_nearest_stored_key_is_compared() -> None:
    far = parts(
        code={"riot.scores.crs": "dddd"}, versions={"numpy": "1.0"}, parameters={"crs": {"lines": 1, "sigma_e": 9.0}}
    )
    changes = explain(parts(versions={"numpy": "2.1"}).to_json(), gather([far.to_json(), parts().to_json()]))
    assert changes == ("versions.numpy '2.0' → '2.1'",)


def test_misses_are_counted_by_reason(tmp_path: Path) -> None:
    store = Store(tmp_path)
    damaged = parts(inputs=("x", "y"))
    for known in (parts(), damaged):
        store.put(known, Artifact())
    payload = store.folder("crs", damaged.key()) / PAYLOAD
    payload.write_bytes(payload.read_bytes()[:-1])
    items = [damaged, parts(inputs=("a", "c")), parts(inputs=("c", "b")), parts(versions={"numpy": "3"})]
    causes = Causes(store).count([WorkItem(key_parts, (), (), None, ()) for key_parts in items])
    assert causes[NOT_DONE] == 2 and causes["versions.numpy '2.0' → '3'"] == 1
    assert sum(count for text, count in causes.items() if text.startswith("corrupt")) == 1


def test_an_empty_store_explains_itself(tmp_path: Path) -> None:
    (text,) = Causes(Store(tmp_path)).count([WorkItem(parts(), (), (), None, ())])
    assert text.startswith("new")

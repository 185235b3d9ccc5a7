"""Preselection: the selection is that from all blocks at once, and a new shape changes only the parts that have it."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from plans import planned

from pipeline.config.build import make_config
from pipeline.datasets.collection import Collection
from pipeline.datasets.item import Item
from pipeline.plan import batches
from pipeline.plan.progress import Progress
from pipeline.plan.work_item import WorkItem
from pipeline.stages import policies, pool
from pipeline.stages.all import BY_NAME
from pipeline.store.artifact import Artifact, encode

NAMES = [f"shape-{number:03}" for number in range(260)]
WISHES: list[dict[str, Any]] = [
    {},
    {"pieces": (3, 5)},
    {"classes": ("class-3",), "exclude": ("shape-031", "class-5")},
    {"policy": "global"},
    {"policy": "global", "per_class_pair": 1, "per_shape": 1, "breadth": 1},
]


@pytest.fixture(autouse=True)
def many_small_groups(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(batches, "LEAST_GROUPS", 64)
    monkeypatch.setattr(batches, "ROOT", 2)
    monkeypatch.setattr(pool, "CHUNK", 200)
    monkeypatch.setattr(pool, "PARTNERS", 2)


def plan(names: Sequence[str], **wishes: Any) -> Progress:
    digests = [hashlib.sha256(name.encode()).hexdigest() for name in names]
    items = [
        Item(name, f"class-{int(name[-3:]) // 7}", f"/pictures/{name}.png", digest)
        for name, digest in zip(names, digests, strict=True)
    ]
    config = make_config({"dataset": {"name": "made-up"}, "batch": 4, "select": {"top": 6, **wishes}})
    return planned(config, "select", Collection("made-up", tuple(items)))


def simulated(progress: Progress, item: WorkItem) -> Artifact:
    """Scores that depend on the two shapes alone, of which many are equal; every fifth shape is doubtful."""
    if item.stage == "ingest":
        return Artifact({"quality_doubtful": np.array([position % 5 == 0 for position in item.members])})
    assert item.block is not None
    a, b = (progress.of_side(item.stage, number) for number in item.block)
    rows, columns = np.divmod(np.arange(len(a) * len(b)), len(b))
    kept = (rows < columns) | (a != b)
    rows, columns = rows[kept], columns[kept]
    i, j = rows + a.start, columns + b.start
    score, n = (i * 7919 + j * 104729) % 97 / 97, 3 + (i * 31 + j) % 5
    if item.stage == "qcrs_rare":
        score, n = 0.9 * score, np.where(n % 2 == 0, 3, 6)
    return Artifact({"i": rows.astype(np.int32), "j": columns.astype(np.int32), "score": score, "n": n.astype(np.int8)})


def computed(progress: Progress, items: Sequence[WorkItem], known: dict[Any, Artifact]) -> Artifact:
    """The artifact of the last of some work items, of stages that select."""
    for item in items:
        for reference in item.sources:
            if reference not in known:
                source = next(other for other in progress.work[reference[0]] if other.reference == reference)
                known[reference] = simulated(progress, source)
        inputs = [known[reference] for reference in item.sources]
        known[item.reference] = BY_NAME[item.stage].run(inputs, item.parameters, item.spec)
    return known[items[-1].reference]


@pytest.mark.parametrize("wishes", WISHES)
@pytest.mark.parametrize("first_pool", [12, 50_000])
def test_the_selection_is_that_from_all_blocks_at_once(
    wishes: dict[str, Any], first_pool: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(policies, "FIRST_POOL", first_pool)
    progress = plan(NAMES, **wishes)
    progress = replace(
        progress,
        work={name: items for name, items in progress.work.items() if name not in ("near_duplicates", "reversibility")},
    )
    progress = replace(progress, work={**progress.work, "reversibility": ()})
    assert len(progress.spans) > 2  # a tree of several levels
    flat = replace(progress, work={name: items for name, items in progress.work.items() if name != "preselect"})
    known: dict[Any, Artifact] = {}
    artifacts = [
        computed(some, [*some.work.get("preselect", ()), *BY_NAME["select"].items(some)], known)
        for some in (progress, flat)
    ]
    assert len(artifacts[0].arrays["pairs"]) > 0
    assert encode(artifacts[0]) == encode(artifacts[1])


def test_a_part_reads_a_bounded_number_of_smaller_ones_and_every_block_is_read_once() -> None:
    progress = plan(NAMES)
    parts, most = progress.work["preselect"], max(batches.GROUPS_JOINED) * batches.SPREAD[1]
    read = [source for part in parts for source in part.sources]
    for stage in ("qcrs", "qcrs_rare"):
        assert sorted(source for source in read if source[0] == stage) == sorted(
            item.reference for item in progress.work[stage]
        )
    smaller = [source for source in read if source[0] == "preselect"]
    assert len(set(smaller)) == len(smaller)
    assert all(sum(source[0] == "preselect" for source in part.sources) <= most**2 for part in parts)
    (select,) = progress.work["select"]
    assert {*smaller, *(s for s in select.sources if s[0] == "preselect")} == {part.reference for part in parts}


def test_a_new_shape_changes_only_the_parts_that_have_it() -> None:
    before, after = plan(NAMES[:-1]), plan(NAMES)
    kept = {part.key for part in before.work["preselect"]} & {part.key for part in after.work["preselect"]}
    # The last shape is in the last span of every level: a part for each span beside it is new.
    new = len(after.work["preselect"]) - len(kept)
    assert 0 < new <= sum(len(level) for level in after.spans[1:])
    other = replace(after.config, select=replace(after.config.select, flat=True))
    assert BY_NAME["preselect"].recipe(other).values == BY_NAME["preselect"].recipe(after.config).values

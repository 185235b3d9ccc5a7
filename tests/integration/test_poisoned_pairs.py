"""Work on pairs, and batches as a whole, that hang or kill: only what is deadly is lost, all else is as without it."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import pandas as pd
import pyarrow.parquet as pq
import pytest
from small_runs import CLEAN, WITH_ERRORS, digests, pictures, table

import pipeline.cache
import pipeline.plan.batches
import pipeline.runtime.quarantine
import pipeline.runtime.worker
import pipeline.stages.shards
import riot.scores.qcrs
from pipeline.config.build import make_config
from pipeline.config.schema import Config
from pipeline.flow import RunOutcome, run_pipeline
from pipeline.plan.sub_block import SubBlock
from pipeline.plan.work_item import Reference
from pipeline.runtime.events import Event, Note
from pipeline.stages.all import BY_NAME, checked_stage
from pipeline.stages.block_rows import ReusingBlock
from pipeline.stages.shape_arrays import count_shapes
from pipeline.stages.stage import Stage
from pipeline.store.artifact import Artifact
from pipeline.store.store import Store

Poison = Callable[[str, Sequence[Any], Any], bool]
"""Whether a stage's work, of inputs and a spec, is deadly."""

TOPK = {"mode": "topk", "k": 3}
BATCHES = 4


class Died(Exception):
    """Stands for the end of the process: a run tells it from an error by its type, and so it is here."""


class Planted:
    """Real runs in this process whose work is deadly where it is poison; ``begun`` are the stages of all other work."""

    def __init__(self, root: Path, patch: pytest.MonkeyPatch) -> None:
        self.root, self.poison, self.begun, self.notes = root, (lambda *_: False), list[str](), list[str]()
        patch.setattr(pipeline.runtime.worker, "DEADLY", pipeline.runtime.worker.DEADLY | {"Died"})
        patch.setattr(pipeline.runtime.worker, "checked_stage", self._poisoned)

    def _poisoned(self, stage: str, code: str) -> Stage:
        work = checked_stage(stage, code)

        def run(inputs: Sequence[Any], parameters: Sequence[Any], spec: Any) -> Artifact:
            if self.poison(stage, inputs, spec):
                raise Died("and is set aside")
            self.begun.append(stage)
            return work.run(inputs, parameters, spec)

        return replace(work, run=run)

    def config(self, where: Path, **qcrs: object) -> Config:
        return make_config(
            {
                "dataset": {"name": "folder", "kind": "folder", "root": str(self.root)},
                "outputs": str(where / "outputs"),
                "store": str(where / "store"),
                "batch": BATCHES,
                "cluster": {"kind": "sync"},
                "refine": {"candidates": 1},
                "construct": {"attempts": 1},
                "select": {"policy": "global", "top": 2, "breadth": 1},
                "qcrs": qcrs,
            }
        )

    def mine(self, where: Path, poison: Poison = lambda *_: False, **qcrs: object) -> RunOutcome:
        self.poison = poison
        self.begun.clear()
        self.notes.clear()

        def listen(event: Event) -> None:
            if isinstance(event, Note):
                self.notes.append(event.text)

        return run_pipeline(self.config(where, **qcrs), listen)


@pytest.fixture(scope="module")
def planted(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Planted]:
    with pytest.MonkeyPatch.context() as patch:
        # Of four kinds, so that pairs of one kind are never selected.
        yield Planted(pictures(tmp_path_factory.mktemp("pictures"), range(11)), patch)


@pytest.fixture(scope="module")
def clean(planted: Planted, tmp_path_factory: pytest.TempPathFactory) -> Path:
    where = tmp_path_factory.mktemp("clean")
    assert planted.mine(where).code == CLEAN
    return where


@pytest.fixture(scope="module")
def clean_topk(planted: Planted, tmp_path_factory: pytest.TempPathFactory) -> Path:
    where = tmp_path_factory.mktemp("topk")
    assert planted.mine(where, **TOPK).code == CLEAN
    return where


@pytest.fixture(scope="module")
def areas(clean: Path) -> dict[float, int]:
    """Shape numbers by the area of the first trunk, by which the work on stacks of trunks knows them."""
    shape_of_area = {row["area"]: row["shape"] for row in table(clean, "trunks") if row["trunk"] == 0}
    assert len(shape_of_area) == len(table(clean, "shapes"))
    return shape_of_area


def numbers(stack: Any, areas: dict[float, int]) -> list[int]:
    return [areas[float(stack.areas[start])] for start in stack.starts[:-1]]


def pairs_of(inputs: Sequence[Any], spec: Any, areas: dict[float, int]) -> set[tuple[int, int]]:
    """Shape numbers of the pairs that work of stage qcrs scores."""
    sides = spec.whole if isinstance(spec, SubBlock) else spec.sides if isinstance(spec, ReusingBlock) else spec
    first, second = ([shape for k in side for shape in numbers(inputs[k], areas)] for side in sides.numbers)
    if isinstance(spec, SubBlock):
        return {(first[i], second[j]) for i, j in spec.pairs()}
    return {(p, q) for p, q in product(first, second) if p < q}


def payloads(where: Path) -> dict[Reference, str]:
    """Digests of everything in the store."""
    return {(entry.stage, entry.key): entry.digest for entry in Store(where / "store").entries()}


def tidied(where: Path) -> bool:
    """Delete what nobody needs from the store; whether that was anything."""
    before = payloads(where)
    locations = ("--store", str(where / "store"), "--outputs", str(where / "outputs"))
    assert pipeline.cache.main(["gc", "--stale", *locations]) == CLEAN
    return payloads(where).keys() < before.keys()


def scores(where: Path) -> pd.DataFrame:
    frame = pq.read_table(where / "outputs" / "folder" / "qcrs").to_pandas()
    return frame.set_index(["i", "j"])


LOST = {"score": float("nan"), "n": -1, "trunk_i": -1, "trunk_j": -1, "shift": -1}


@pytest.mark.parametrize("which", [slice(1), slice(None)])
def test_only_deadly_pairs_are_lost(
    which: slice, planted: Planted, clean: Path, areas: dict[float, int], tmp_path: Path
) -> None:
    classes = [row["class"] for row in table(clean, "shapes")]
    # Pairs of one class, which are never selected.
    chosen = {(p, q) for q in range(len(classes)) for p in range(q) if classes[p] == classes[q]}
    chosen = set(sorted(chosen)[which])
    assert chosen

    def poison(stage: str, inputs: Sequence[Any], spec: Any) -> bool:
        return stage == "qcrs" and not chosen.isdisjoint(pairs_of(inputs, spec, areas))

    outcome = planted.mine(tmp_path, poison)
    assert outcome.code == WITH_ERRORS
    names = [row["name"] for row in table(clean, "shapes")]
    words = {f"{names[p]} × {names[q]}" for p, q in chosen}
    errors = table(tmp_path, "errors")
    assert {(row["item"], row["stage"], row["type"]) for row in errors} == {(word, "qcrs", "Died") for word in words}
    assert len(errors) == len(chosen) and all(word in "".join(planted.notes) for word in words)
    expected = scores(clean)
    for pair in chosen:
        expected.loc[pair, list(LOST)] = list(LOST.values())
    pd.testing.assert_frame_equal(scores(tmp_path), expected.astype(scores(clean).dtypes), check_exact=True)
    got, wanted = digests(tmp_path), digests(clean)
    assert got.keys() == wanted.keys()
    differ = {name for name in got if got[name] != wanted[name]}
    assert {name for name in differ if not name.startswith("qcrs/")} == {"errors.parquet", "artifacts.json"}
    # The next run tries the block and the pair again, and nothing else; once they do well nothing is lost.
    assert not tidied(tmp_path)
    assert planted.mine(tmp_path, poison).code == WITH_ERRORS and planted.begun == []
    assert planted.mine(tmp_path).code == CLEAN and set(planted.begun) == {"qcrs", "select"}
    assert digests(tmp_path) == wanted


def test_blocks_of_larger_groups_give_the_same_bytes_and_use_what_is_there(
    planted: Planted, clean: Path, areas: dict[float, int], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copytree(clean / "store", tmp_path / "store")
    monkeypatch.setattr(pipeline.plan.batches, "LEAST_GROUPS", 1)
    scored: list[int] = []
    score_block = riot.scores.qcrs.score_block
    monkeypatch.setattr(
        riot.scores.qcrs, "score_block", lambda *some, **more: scored.append(1) or score_block(*some, **more)
    )
    assert planted.mine(tmp_path).code == CLEAN and set(planted.begun) == {"qcrs", "select"} and scored == []
    assert scores(tmp_path).equals(scores(clean))
    # From nothing, and with deadly pairs in a block of several batches.
    for poisoned in ((), ((0, 4), (1, 5))):

        def poison(stage: str, inputs: Sequence[Any], spec: Any, chosen: Any = frozenset(poisoned)) -> bool:
            return stage == "qcrs" and not chosen.isdisjoint(pairs_of(inputs, spec, areas))

        where = tmp_path / f"{len(poisoned)}"
        assert planted.mine(where, poison).code == (WITH_ERRORS if poisoned else CLEAN)
        expected = scores(clean)
        for pair in poisoned:
            expected.loc[pair, list(LOST)] = list(LOST.values())
        pd.testing.assert_frame_equal(scores(where), expected.astype(scores(clean).dtypes), check_exact=True)


def test_a_block_that_fails_only_as_a_whole_is_done_in_parts(
    planted: Planted, clean: Path, areas: dict[float, int], tmp_path: Path
) -> None:
    def poison(stage: str, inputs: Sequence[Any], spec: Any) -> bool:
        return stage == "qcrs" and len(pairs_of(inputs, spec, areas)) > 5

    outcome = planted.mine(tmp_path, poison)
    assert outcome.code == CLEAN and digests(tmp_path) == digests(clean)
    (stage,) = (stage for stage in outcome.results.stages if stage.stage == "qcrs")
    assert stage.failed == 0 and stage.computed == stage.total
    # Another run may commit the block as a whole at the same time: the joined one has its bytes.
    assert payloads(clean).items() <= payloads(tmp_path).items() and tidied(tmp_path)
    assert payloads(clean) == payloads(tmp_path)
    again = planted.mine(tmp_path, poison)
    assert (again.code, again.written, planted.begun) == (CLEAN, False, [])


def test_a_batch_that_fails_only_as_a_whole_is_done_shape_by_shape(
    planted: Planted, clean: Path, tmp_path: Path
) -> None:
    def poison(stage: str, inputs: Sequence[Any], spec: Any) -> bool:
        return BY_NAME[stage].scope == "batch" and (len(spec) if stage == "ingest" else count_shapes(inputs[0])) > 1

    assert planted.mine(tmp_path, poison).code == CLEAN
    assert digests(tmp_path) == digests(clean)
    assert payloads(clean).items() <= payloads(tmp_path).items() and tidied(tmp_path)
    assert planted.mine(tmp_path, poison).code == CLEAN and planted.begun == []


def test_more_failures_than_single_pairs_explain_are_not_searched(
    planted: Planted, clean: Path, areas: dict[float, int], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One shape is deadly with all others: after a few halvings what it is in is lost as it is."""
    monkeypatch.setattr(pipeline.runtime.quarantine, "MOST", 4)
    tried: list[int] = []

    def poison(stage: str, inputs: Sequence[Any], spec: Any) -> bool:
        pairs = pairs_of(inputs, spec, areas) if stage == "qcrs" else set()
        deadly = any(0 in pair for pair in pairs)
        tried.extend([len(pairs)] * deadly)
        return deadly

    assert planted.mine(tmp_path, poison).code == WITH_ERRORS
    got, expected = scores(tmp_path), scores(clean)
    lost = got.n == -1
    assert lost[0].all() and lost.sum() < len(got) / 2 and max(tried) > 4 and 1 not in tried[-2:]
    assert got[lost].score.isna().all()
    pd.testing.assert_frame_equal(got[~lost], expected[~lost], check_exact=True)


def test_a_deadly_search_loses_one_shape_s_partners_in_one_part(
    planted: Planted, clean_topk: Path, areas: dict[float, int], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def poison(stage: str, inputs: Sequence[Any], spec: Any) -> bool:
        if stage != "partners":
            return False
        rows = range(*spec.rows) if isinstance(spec, SubBlock) else range(len(inputs[0]))
        return 3 in [numbers(inputs[0], areas)[row] for row in rows]

    outcome = planted.mine(tmp_path, poison, **TOPK)
    assert outcome.code == WITH_ERRORS and outcome.results.search is not None
    assert outcome.results.search.missed == 1 and "1 shape could not be searched" in outcome.results.search.sentence(0)
    name = table(clean_topk, "shapes")[3]["name"]
    assert [(row["item"], row["stage"]) for row in table(tmp_path, "errors")] == [(name, "partners")]
    got, expected = scores(tmp_path), scores(clean_topk)
    gone = expected.index.difference(got.index)
    assert len(gone) and all(3 in pair for pair in gone)
    pd.testing.assert_frame_equal(got, expected.loc[got.index], check_exact=True)
    assert planted.mine(tmp_path, **TOPK).code == CLEAN and digests(tmp_path) == digests(clean_topk)


def test_a_search_that_fails_only_as_a_whole_is_done_in_parts(
    planted: Planted, clean_topk: Path, tmp_path: Path
) -> None:
    def poison(stage: str, inputs: Sequence[Any], spec: Any) -> bool:
        return stage == "partners" and not isinstance(spec, SubBlock) and len(inputs[0]) > 1

    assert planted.mine(tmp_path, poison, **TOPK).code == CLEAN
    assert digests(tmp_path) == digests(clean_topk)
    assert payloads(clean_topk).items() <= payloads(tmp_path).items() and tidied(tmp_path)
    assert planted.mine(tmp_path, poison, **TOPK).code == CLEAN and planted.begun == []


def test_a_deadly_shard_is_missing_and_the_others_are_searched(
    planted: Planted, clean_topk: Path, areas: dict[float, int], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pipeline.stages.shards, "SHAPES_PER_SHARD", BATCHES)

    def poison(stage: str, inputs: Sequence[Any], spec: Any) -> bool:
        return stage == "shards" and 0 in numbers(inputs[0], areas)

    outcome = planted.mine(tmp_path, poison, **TOPK)
    search = outcome.results.search
    assert outcome.code == WITH_ERRORS and search is not None and outcome.results.pairs
    assert search.missed == search.shapes == len(areas)  # none of them was compared with those of the shard
    (shard,) = (item for item in outcome.results.work["shards"] if item.reference in outcome.results.failed)
    got = scores(tmp_path)
    assert len(got) and not any(set(pair) <= set(shard.members) for pair in got.index)
    assert any(set(pair) & set(shard.members) for pair in got.index)  # found from the other side

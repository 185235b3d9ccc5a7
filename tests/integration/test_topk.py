"""qcrs.mode=topk: the best partners of every shape are those of all pairs, to the bit, whatever the shards."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from PIL import Image
from plans import planned as planned_run
from small_runs import CLEAN, digests, draw, pictures, run, run_here, stages

import pipeline.stages.partners_beyond
import pipeline.stages.shards
from pipeline.config.build import make_config
from pipeline.config.schema import Config
from pipeline.datasets.collection import Collection
from pipeline.datasets.item import Item
from pipeline.errors import ConfigError
from pipeline.flow import run_pipeline
from pipeline.plan.progress import Progress
from pipeline.runtime.events import Event, StageEnded
from pipeline.stages.all import BY_NAME
from pipeline.stages.search_spec import ShardPosition
from pipeline.store.keys import digest_text
from pipeline.tables.partner_search import PartnerSearch, read_search

SHAPES = 23
COPIES = (30, 31, 32, 33)


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Shapes of four kinds, and copies of some of them, so that there are equal scores in every part."""
    folder = pictures(tmp_path_factory.mktemp("pictures"), range(SHAPES))
    for number in COPIES:
        for original in (1, 6):
            with Image.open(folder / f"kind{original % 4}-{original}.png") as image:
                # Other bytes of the same picture: the same bytes would be rejected.
                image.save(folder / f"kind{number % 4}-{number}{original}.png", compress_level=number - COPIES[0])
    return folder


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("store")


@dataclass(frozen=True)
class Pairs:
    """The table of a run, what it says of the search, the selection, and the stages that ran."""

    table: pd.DataFrame
    search: PartnerSearch | None
    selected: pd.DataFrame
    stages: dict[str, StageEnded]


def configure(root: Path, where: Path, store: Path, **groups: object) -> Config:
    values = {
        "dataset": {"name": "folder", "kind": "folder", "root": str(root)},
        "outputs": str(where),
        "store": str(store),
        "batch": 4,
        "cluster": {"kind": "sync"},
        "refine": {"candidates": 1},
        "construct": {"attempts": 1},
        "select": {"policy": "global", "top": 3, "breadth": 1},
    }
    return make_config({**values, **groups})


def mine(config: Config) -> Pairs:
    ended: dict[str, StageEnded] = {}

    def listen(event: Event) -> None:
        if isinstance(event, StageEnded):
            ended[event.stage] = event

    outcome = run_pipeline(config, listen)
    assert outcome.code == CLEAN, outcome.results.errors
    table = pq.read_table(outcome.folder / "qcrs").to_pandas().reset_index(drop=True)
    files = sorted((outcome.folder / "qcrs").rglob("*.parquet"))
    selected = pq.read_table(outcome.folder / "selected.parquet").to_pandas()
    return Pairs(table, read_search(pq.read_schema(files[0]).metadata), selected, ended)


def best_of(every: pd.DataFrame, k: int) -> pd.DataFrame:
    """Of all pairs those that are among the k best of either shape, by the definition."""
    scored = every[every.score > 0]
    sides = pd.concat([scored.assign(of=scored.i, other=scored.j), scored.assign(of=scored.j, other=scored.i)])
    sides = sides.sort_values(["of", "score", "other"], ascending=[True, False, True])
    kept = sides.groupby("of").head(k)[list(every.columns)].drop_duplicates()
    return kept.sort_values(["i", "j"]).reset_index(drop=True)


@pytest.fixture(scope="module")
def every(root: Path, store: Path, tmp_path_factory: pytest.TempPathFactory) -> Pairs:
    return mine(configure(root, tmp_path_factory.mktemp("all"), store))


@pytest.mark.parametrize(("k", "shard"), [(1, 8), (3, 4), (3, 640), (7, 8), (1000, 8)])
def test_the_pairs_are_the_best_of_all(
    k: int, shard: int, every: Pairs, root: Path, store: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pipeline.stages.shards, "SHAPES_PER_SHARD", shard)
    kept = mine(configure(root, tmp_path, store, qcrs={"mode": "topk", "k": k}))
    assert (kept.stages["shards"].total > 1) == (shard < 640)
    assert len(best_of(every.table, k)) > SHAPES // 2
    pd.testing.assert_frame_equal(kept.table, best_of(every.table, k), check_exact=True)
    shapes = SHAPES + 2 * len(COPIES)
    assert every.search is None and kept.search is not None
    assert (kept.search.k, kept.search.shapes) == (k, shapes)


def test_the_pairs_are_the_same_however_many_shards_are_searched_in_a_row(
    root: Path, store: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pipeline.stages.shards, "SHAPES_PER_SHARD", 4)
    qcrs = {"mode": "topk", "k": 1}
    monkeypatch.setattr(pipeline.stages.shards, "TARGET", 1)
    one = mine(configure(root, tmp_path / "one", store, qcrs=qcrs))
    monkeypatch.setattr(pipeline.stages.shards, "TARGET", 3)
    several = mine(configure(root, tmp_path / "several", store, qcrs=qcrs))
    searches = [mined.stages["partners_beyond"].total for mined in (one, several)]
    assert searches[1] < 0.7 * searches[0]
    pd.testing.assert_frame_equal(several.table, one.table, check_exact=True)


def test_searches_grow_with_the_shapes(tmp_path: Path) -> None:
    names = [f"{number:06d}" for number in range(60_000)]
    items = tuple(Item(name, "", name, digest_text(name)) for name in names)
    config = configure(tmp_path, tmp_path, tmp_path, qcrs={"mode": "topk"}, batch=32)
    counts = []
    for shapes in (15_000, 60_000):
        plan = planned_run(config, "pairs", Collection("many", items[:shapes]))
        pairs = 0
        for item in (*plan.work["partners"], *plan.work["partners_beyond"]):
            assert item.block is not None
            pairs += item.pairs
        assert pairs == shapes**2
        counts.append(len(plan.work["partners"]) + len(plan.work["partners_beyond"]))
    assert counts[1] < 8 * counts[0]


@pytest.mark.parametrize("policy", ["global", "paper"])
def test_with_enough_partners_the_selection_is_that_of_all_pairs(
    policy: str, root: Path, store: Path, tmp_path: Path
) -> None:
    select = {"policy": policy, "top": 5, "breadth": 1}
    whole = mine(configure(root, tmp_path / "all", store, select=select))
    kept = mine(configure(root, tmp_path / "topk", store, select=select, qcrs={"mode": "topk", "k": 30}))
    pd.testing.assert_frame_equal(kept.selected, whole.selected, check_exact=True)
    assert len(kept.selected) == 5


def test_one_more_picture_changes_its_own_shard(root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pipeline.stages.shards, "SHAPES_PER_SHARD", 8)
    grown = Path(shutil.copytree(root, tmp_path / "grown"))
    topk = {"mode": "topk", "k": 3}
    mine(configure(root, tmp_path / "before", tmp_path / "store", qcrs=topk))
    again = mine(configure(root, tmp_path / "again", tmp_path / "store", qcrs=topk))
    assert all(stage.computed == 0 for stage in again.stages.values())
    draw(grown / "kind9-99.png", 99)
    after = mine(configure(grown, tmp_path / "after", tmp_path / "store", qcrs=topk))
    assert 1 <= after.stages["shards"].computed <= 2 and after.stages["shards"].cached > 0
    assert after.stages["partners"].cached > after.stages["partners"].computed / 4
    whole = mine(configure(grown, tmp_path / "whole", tmp_path / "store"))
    pd.testing.assert_frame_equal(after.table, best_of(whole.table, 3), check_exact=True)


def planned(root: Path, tmp_path: Path, until: str, **qcrs: object) -> Progress:
    return planned_run(configure(root, tmp_path, tmp_path, qcrs=qcrs), until)


def test_which_pairs_are_scored_is_no_part_of_the_keys_of_scores(root: Path, tmp_path: Path) -> None:
    usual, changed = planned(root, tmp_path, "qcrs"), planned(root, tmp_path, "qcrs", k=3)
    assert [item.key for item in usual.work["qcrs"]] == [item.key for item in changed.work["qcrs"]]
    assert usual.recipes["qcrs"].values == {"qcrs": usual.recipes["qcrs"].values["qcrs"]}
    assert set(usual.recipes["qcrs"].values["qcrs"]) == {"sigma_e", "sigma_angle", "sigma_area", "epsilon"}
    first, second = (planned(root, tmp_path, "partners", mode="topk", k=k) for k in (20, 3))
    assert [item.key for item in first.work["shards"]] == [item.key for item in second.work["shards"]]
    assert not {item.key for item in first.work["partners"]} & {item.key for item in second.work["partners"]}


def test_a_lost_batch_costs_its_own_pairs_only(root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pipeline.stages.shards, "SHAPES_PER_SHARD", 8)
    monkeypatch.setattr(pipeline.stages.shards, "TARGET", 1)
    whole = planned(root, tmp_path, "trunks", mode="topk")
    lost = whole.work["trunks"][2]
    left = whole.with_work("trunks", whole.work["trunks"], whole.done - {lost.reference})
    for stage in ("shards", "partners", "partners_beyond", "pairs"):
        items = BY_NAME[stage].items(left)
        left = left.with_work(stage, items, left.done | {item.reference for item in items})
    shards = left.work["shards"]
    members = {position for shard in shards for position in shard.members}
    assert members == set(range(len(whole.items))) - set(lost.members)
    for shard in shards:
        assert list(shard.members) == list(range(shard.members[0], shard.members[-1] + 1))
    searches = [*left.work["partners"], *left.work["partners_beyond"]]
    assert len(searches) == len(shards) * sum(len(shard.sources) for shard in shards)
    for item in searches:
        assert item.block is not None and lost.reference not in item.sources
        (start, *_), members_of = item.members, shards[item.block[1]].members
        inside = members_of.index(start) if start in members_of else -1
        assert item.spec.shards == (ShardPosition(inside, start > members_of[-1], 0),)
    ((collected,), (select,)) = left.work["pairs"], BY_NAME["select"].items(left)
    assert select.sources[0] == collected.reference


@pytest.mark.parametrize("shard", [8, 640])
def test_the_approximate_mode_finds_most_of_the_best_pairs_with_their_exact_scores(
    shard: int, every: Pairs, root: Path, store: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pipeline.stages.shards, "SHAPES_PER_SHARD", shard)
    kept = mine(configure(root, tmp_path, store, qcrs={"mode": "approximate", "k": 3}))
    best = best_of(every.table, 3)
    found = best.merge(kept.table[["i", "j"]], on=["i", "j"])
    assert len(found) == len(best) if shard == 640 else len(found) >= 0.9 * len(best)
    exact = kept.table[["i", "j"]].merge(every.table, on=["i", "j"])
    pd.testing.assert_frame_equal(kept.table, exact, check_exact=True)
    assert kept.search is not None and kept.search.approximate == 1
    assert "nearly every pair" in kept.search.sentence(1) and "qcrs.mode=approximate" in kept.search.sentence(1)


TOPK = ("qcrs.mode=topk", "qcrs.k=3")


@pytest.mark.system
@pytest.mark.parametrize("mode", ["topk", "approximate"])
def test_two_workers_write_the_same_bytes(mode: str, root: Path, tmp_path: Path) -> None:
    for name, cluster in (("one", ("cluster=sync",)), ("two", ("cluster=local", "cluster.workers=2"))):
        done = run(tmp_path / name, root, f"qcrs.mode={mode}", "qcrs.k=3", *cluster)
        assert done.returncode == CLEAN, done.stdout + done.stderr
    assert digests(tmp_path / "one") == digests(tmp_path / "two")


def test_the_output_names_the_mode_and_what_it_leaves_out(root: Path, tmp_path: Path) -> None:
    plan = run_here(tmp_path / "one", root, *TOPK, "--plan")
    assert plan.returncode == CLEAN and "nothing was run" in plan.stdout
    done = run_here(tmp_path / "one", root, *TOPK, "cluster=sync")
    assert done.returncode == CLEAN, done.stdout + done.stderr
    assert {"shards", "partners", "pairs"} <= stages(tmp_path / "one").keys() and "qcrs" not in stages(tmp_path / "one")
    search = read_search(pq.read_schema(next((tmp_path / "one").rglob("qcrs/*.parquet"))).metadata)
    assert search is not None
    for text in (done.stdout, (tmp_path / "one" / "outputs" / "folder" / "report.html").read_text(encoding="utf-8")):
        assert f"of {search.pairs:,} pairs kept, every pair" in text and "best partners of the other" in text
    again = run_here(tmp_path / "one", root, *TOPK, "cluster=sync")
    assert again.returncode == CLEAN and "Everything cached" in again.stdout
    why = run_here(tmp_path / "one", root, *TOPK, "qcrs.sigma_e=0.2", "--explain")
    assert why.returncode == CLEAN and "parameters.qcrs.sigma_e 0.1 → 0.2" in why.stdout


def test_a_collection_without_shapes_has_no_partners(tmp_path: Path) -> None:
    (tmp_path / "root").mkdir()
    draw(tmp_path / "root" / "one.png", 1)
    kept = mine(configure(tmp_path / "root", tmp_path / "out", tmp_path / "store", qcrs={"mode": "topk"}))
    assert len(kept.table) == 0 and kept.search == PartnerSearch(20, 1, 0)


@pytest.mark.parametrize(
    ("qcrs", "words"),
    [({"mode": "some"}, "qcrs.mode: 'some' is not allowed; choose one of all, topk, approximate"),
     ({"k": 0}, "qcrs.k: must be 1 or more, got 0"), ({"k": 2.5}, "qcrs.k: expected a whole number, got 2.5")],
)  # fmt: skip
def test_wrong_values_are_named(qcrs: dict[str, object], words: str) -> None:
    with pytest.raises(ConfigError, match="qcrs") as caught:
        make_config({"dataset": {"name": "sample", "kind": "sample"}, "qcrs": qcrs})
    assert words in str(caught.value)


def test_a_plain_table_says_nothing_of_a_search() -> None:
    assert read_search(None) is None and read_search({b"k": b"3"}) is None
    search = PartnerSearch(3, 10, 4)
    assert read_search(search.schema().metadata) == search
    assert np.all([word in search.sentence(20) for word in ("20 of 45 pairs", "3 best partners", "4 shapes")])

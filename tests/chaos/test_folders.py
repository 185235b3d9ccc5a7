"""A data set given by a relative path: the same run for workers in any working folder, to the byte."""

from __future__ import annotations

import functools
import os
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from chaos.conftest import Undisturbed
from chaos.nursery import Nursery
from chaos.victims import begun, mine, settings
from integration.small_runs import digests
from plans import planned

from pipeline.config.schema import Config
from pipeline.datasets.collection import DatasetConfig, collect
from pipeline.runtime.inputs import InputCache
from pipeline.runtime.worker import run_items
from pipeline.store.store import Store


def relative(where: Path) -> Config:
    return settings(Path("pictures"), where)


def test_a_worker_elsewhere_finds_the_pictures(
    undisturbed: Undisturbed, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(undisturbed.where)
    config = relative(tmp_path)
    ingest = planned(config, "ingest").work["ingest"]
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")  # as a worker that was started there
    receipts = list(run_items(Store(config.store), ingest, InputCache()))
    assert [receipt.failure for receipt in receipts] == [None] * len(ingest)
    assert {item.reference for item in ingest} <= undisturbed.artifacts


@pytest.mark.parametrize("root", ["pictures", "./pictures/../pictures", "."])
def test_where_the_data_set_lies_is_in_no_key_and_no_table(
    root: str, nursery: Nursery, undisturbed: Undisturbed, tmp_path: Path
) -> None:
    moved = tmp_path / "checkout"
    shutil.copytree(undisturbed.pictures, moved / "pictures")
    shutil.copytree(undisturbed.where / "store", tmp_path / "store")
    config = replace(relative(tmp_path), dataset=DatasetConfig("folder", "folder", root))
    enter = functools.partial(os.chdir, moved / "pictures" if root == "." else moved)
    assert nursery.call(mine, config, tmp_path / "log", enter) == 0
    assert begun(tmp_path / "log") == [] and digests(tmp_path) == undisturbed.tables


def test_names_that_are_no_text_are_named_below_the_root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / os.fsdecode(b"caf\xe9-1.png")).write_bytes(b"")
    monkeypatch.chdir(tmp_path)
    names = {collect(DatasetConfig("m", "folder", root)).rejected[0].name for root in (".", str(tmp_path))}
    assert names == {"caf\\udce9-1"}

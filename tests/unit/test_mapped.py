"""The memory of mapped artifacts is given back, and what was in it is still there."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pipeline.store.artifact import Artifact
from pipeline.store.filesystem.local import MAPPED_SIZE
from pipeline.store.keys import KeyParts
from pipeline.store.mapped import let_go
from pipeline.store.store import Store

SMAPS = Path("/proc/self/smaps")


def resident_kb(below: Path) -> int:
    """Kilobytes of the files below a folder that are in this process's memory."""
    total, inside = 0, False
    for line in SMAPS.read_text(encoding="utf-8").splitlines():
        name, *values = line.split()
        if "-" in name:
            inside = values[-1].startswith(str(below))
        elif name == "Rss:" and inside:
            total += int(values[0])
    return total


def artifact_in(folder: Path, size: int) -> Artifact:
    store = Store(folder)
    key = store.put(KeyParts("stage", {}, (), {}, {}), Artifact({"a": np.arange(size), "b": np.arange(3)}))
    return store.get("stage", key)


@pytest.mark.skipif(not SMAPS.exists(), reason="the system does not tell what is in memory")
def test_the_memory_of_a_mapped_artifact_is_given_back(tmp_path: Path) -> None:
    artifact = artifact_in(tmp_path, MAPPED_SIZE)
    assert resident_kb(tmp_path) >= MAPPED_SIZE * 8 // 1024
    let_go(artifact)
    assert resident_kb(tmp_path) == 0
    assert np.array_equal(artifact.arrays["a"], np.arange(MAPPED_SIZE)) and artifact.arrays["b"].tolist() == [0, 1, 2]


def test_an_artifact_that_is_not_mapped_stays_as_it_is(tmp_path: Path) -> None:
    for artifact in (artifact_in(tmp_path, 5), Artifact({"a": np.arange(5)}), Artifact()):
        let_go(artifact)
        assert all(array.tolist() == [0, 1, 2, 3, 4][: len(array)] for array in artifact.arrays.values())

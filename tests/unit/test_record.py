"""Whether a folder still has the files of its run: by size and time, and by their bytes where these differ."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from pipeline.store.keys import digest_bytes
from pipeline.tables.record import FORMAT, RECORD, REPORT, VERSION, is_up_to_date, stamp


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    files = [tmp_path / name for name in (REPORT, "shapes.parquet")]
    for file in files:
        file.write_bytes(b"as it was written")
    record = {
        "format": FORMAT,
        "version": VERSION,
        "outcome": "abc",
        "files": {file.name: digest_bytes(file.read_bytes()) for file in files},
        "stamps": {file.name: stamp(file) for file in files},
    }
    (tmp_path / RECORD).write_text(json.dumps(record))
    return tmp_path


def test_files_of_their_size_and_time_are_not_read(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    read: list[str] = []
    read_bytes = Path.read_bytes
    monkeypatch.setattr(Path, "read_bytes", lambda path: (read.append(path.name), read_bytes(path))[1])
    assert is_up_to_date(folder, "abc") and read == [RECORD]
    os.utime(folder / "shapes.parquet", ns=(0, 0))  # as a copy has another time
    assert is_up_to_date(folder, "abc") and read[-1] == "shapes.parquet"


def test_an_altered_or_missing_file_is_found_and_another_outcome(folder: Path) -> None:
    assert not is_up_to_date(folder, "another")
    (folder / "shapes.parquet").write_bytes(b"as it was altered")
    assert not is_up_to_date(folder, "abc")
    (folder / "shapes.parquet").unlink()
    assert not is_up_to_date(folder, "abc")

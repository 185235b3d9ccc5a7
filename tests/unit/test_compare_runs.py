"""Two runs are equal when every value is, to the bit; what differs is named, and times are left out."""

from __future__ import annotations

import contextlib
import io
import json
import runpy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

MAIN = runpy.run_path(str(Path(__file__).parents[2] / "benchmarks" / "compare_runs.py"))["main"]


def write_run(folder: Path) -> None:
    """A small folder with a file of each kind."""
    tables = {
        "shapes": {"shape": [0, 1], "name": ["a", None], "width": [0.5, float("nan")]},
        "trunks": {"shape": [0, 1], "vertices": [[1, 2, 3], []]},
        "qcrs/i_block=0000/part-0": {"i": [0], "j": [1], "score": [0.0]},
        "errors": {"item": ["x"], "key": ["aa"]},
        "timings": {"stage": ["ingest"], "seconds": [1.0]},
    }
    for name, columns in tables.items():
        change(folder / f"{name}.parquet", columns)
    for folder_name in ("transforms", "print/0001"):
        (folder / folder_name).mkdir(parents=True)
    (folder / "transforms" / "0001.riot").write_text(json.dumps({"version": 2, "bound_p": 0.5, "history": {"a": 1}}))
    (folder / "print" / "0001" / "piece.svg").write_text("<svg/>")


def change(path: Path, columns: dict[str, Any]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    kept = pq.ParquetFile(path).read().to_pydict() if path.exists() else {}
    pq.write_table(pa.table(kept | columns), path)


def compare(first: Path, second: Path, *options: str) -> tuple[int, str]:
    with contextlib.redirect_stdout(io.StringIO()) as output, contextlib.redirect_stderr(output):
        code = MAIN([str(first), str(second), *options])
    return code, output.getvalue()


@pytest.fixture
def runs(tmp_path: Path) -> tuple[Path, Path]:
    for name in ("first", "second"):
        write_run(tmp_path / name)
    return tmp_path / "first", tmp_path / "second"


def test_equal_runs_may_differ_in_times_digests_and_history(runs: tuple[Path, Path]) -> None:
    first, second = runs
    change(second / "timings.parquet", {"seconds": [2.0]})
    change(second / "errors.parquet", {"key": ["bb"]})
    (second / "transforms" / "0001.riot").write_text(json.dumps({"version": 2, "bound_p": 0.5, "history": None}))
    assert compare(first, second) == (0, "The runs are equal.\n")
    code, message = compare(first, second, "--ignore", "")
    assert code == 1 and "errors.parquet: key" in message and "timings.parquet: seconds" in message


Edit = Callable[[Path], object]


@pytest.mark.parametrize(
    ("edit", "words"),
    [
        (lambda run: change(run / "shapes.parquet", {"width": [0.5000000000000001, float("nan")]}), "width: 1 of 2"),
        (lambda run: change(run / "shapes.parquet", {"name": ["a", "b"]}), "shapes.parquet: name: 1 of 2"),
        (lambda run: change(run / "shapes.parquet", {"shape": [0.0, 1.0]}), "shape: type int64 and double"),
        (lambda run: change(run / "shapes.parquet", {"depth": [1, 2]}), "columns depth are in one table only"),
        (lambda run: change(run / "trunks.parquet", {"vertices": [[1, 2, 4], []]}), "vertices: 1 of 2 rows differ"),
        (lambda run: change(run / "trunks.parquet", {"vertices": [[1, 2], [3]]}), "vertices: 2 of 2 rows differ"),
        (lambda run: change(run / "qcrs/i_block=0000/part-0.parquet", {"score": [-0.0]}), "score: 1 of 1"),
        (lambda run: (run / "trunks.parquet").unlink(), "is missing"),
        (lambda run: (run / "print" / "0001" / "piece.svg").write_text("<svg> "), "differ from byte 4"),
        (
            lambda run: (run / "transforms" / "0001.riot").write_text('{"version": 2, "bound_p": 0.6}'),
            "bound_p differs",
        ),
    ],
)
def test_every_difference_is_named(runs: tuple[Path, Path], edit: Edit, words: str) -> None:
    first, second = runs
    edit(second)
    code, message = compare(first, second)
    assert code == 1 and words in message


def test_a_folder_without_a_run_is_refused(tmp_path: Path) -> None:
    code, message = compare(tmp_path, tmp_path)
    assert code == 2 and "holds no finished run" in message

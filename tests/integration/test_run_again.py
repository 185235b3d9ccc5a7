"""The same command again: a finished run computes nothing, and what was lost, changed or broken off goes on."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
from pathlib import Path

import psutil
import pytest
from small_runs import (
    CLEAN,
    INTERRUPTED,
    SHAPES,
    command,
    digests,
    draw,
    run_here,
    stages,
    table,
)

from pipeline.store.store import PAYLOAD


def test_a_finished_run_computes_nothing_and_says_so(copied: Path, root: Path) -> None:
    folder = copied / "outputs" / "folder"
    before = {file: file.stat().st_mtime_ns for file in folder.rglob("*")}
    done = run_here(copied, root, "cluster=sync")
    assert done.returncode == CLEAN and "Everything cached: nothing was computed" in done.stdout
    assert {file: file.stat().st_mtime_ns for file in folder.rglob("*")} == before
    plan = run_here(copied, root, "--plan")
    assert plan.returncode == CLEAN and "nothing was run" in plan.stdout
    facts = json.loads(run_here(copied, root, "cluster=sync", "--json").stdout)
    assert (facts["format"], facts["version"], facts["exit_code"]) == ("riot-mine", 1, CLEAN)
    assert [(stage["computed"], stage["cached"]) for stage in facts["stages"]] == [
        (0, stage["items"]) for stage in facts["stages"]
    ]
    assert {stage["stage"] for stage in facts["stages"]} == set(stages(copied))
    assert Path(facts["report"]).is_file()


def test_lost_tables_are_written_again_from_the_store(copied: Path, finished: Path, root: Path) -> None:
    (copied / "outputs" / "folder" / "crs.parquet").unlink()
    done = run_here(copied, root, "cluster=sync")
    assert done.returncode == CLEAN and "nothing was computed" in done.stdout
    assert digests(copied) == digests(finished)
    assert all(stage["computed"] == 0 for stage in stages(copied).values())


def test_one_more_picture_costs_its_own_batch_and_blocks(copied: Path, root: Path, tmp_path: Path) -> None:
    grown = Path(shutil.copytree(root, tmp_path / "grown"))
    draw(grown / "kind9-99.png", 99)
    done = run_here(copied, grown, "cluster=sync")
    assert done.returncode == CLEAN
    counts = stages(copied)
    assert counts["ingest"]["computed"] <= 2 and counts["ingest"]["cached"] >= 1
    assert counts["qcrs"]["cached"] >= 1
    assert len(table(copied, "shapes")) == SHAPES + 1


def test_a_parameter_redoes_what_reads_it_and_explains(copied: Path, root: Path) -> None:
    explained = run_here(copied, root, "crs.sigma_area=0.25", "compare=1", "--explain")
    assert explained.returncode == CLEAN
    assert "crs: 6 of 6 to do" in explained.stdout and "parameters.crs.sigma_area 0.3 → 0.25" in explained.stdout
    assert "qcrs: all" in explained.stdout and "paper: known after construct" in explained.stdout
    done = run_here(copied, root, "crs.sigma_area=0.25", "compare=1", "cluster=sync")
    assert done.returncode == CLEAN, done.stdout + done.stderr
    counts = stages(copied)
    assert counts["qcrs"]["computed"] == 0 and counts["trunks_full"]["computed"] == 0 and counts["crs"]["computed"] == 6
    # The best one was made by the paper's method too.
    best, *others = table(copied, "transforms")
    assert counts["paper"]["computed"] == 1 and 0.5 < best["paper_iou"] < 1.0  # type: ignore[operator]
    assert all(row["paper_iou"] is None for row in others)
    assert "Beside the paper's method" in done.stdout
    assert '<section id="beside">' in (copied / "outputs" / "folder" / "report.html").read_text()


def test_a_damaged_artifact_is_made_again(copied: Path, finished: Path, root: Path) -> None:
    payload = next(iter(sorted((copied / "store" / "trunks").rglob(PAYLOAD))))
    raw = bytearray(payload.read_bytes())
    raw[-1] ^= 255
    payload.write_bytes(raw)
    done = run_here(copied, root, "cluster=sync")
    assert done.returncode == CLEAN and "trunks: 1 damaged" in done.stdout and "corrupt" in done.stdout
    assert re.search(r"^trunks +10 shapes, \d of them in the store in", done.stdout, re.MULTILINE)
    assert payload.read_bytes() != bytes(raw) and digests(copied) == digests(finished)


@pytest.mark.parametrize("after", ["ingest", pytest.param("qcrs", marks=pytest.mark.system)])
def test_a_killed_run_goes_on_where_it_was(after: str, finished: Path, root: Path, tmp_path: Path) -> None:
    with subprocess.Popen(
        command(tmp_path, root, "cluster=local", "cluster.workers=1"), stdout=subprocess.PIPE, text=True, cwd=tmp_path
    ) as process:
        assert process.stdout is not None
        for line in process.stdout:
            if line.startswith(after) and (" shapes in " in line or " pairs in " in line):
                break
        process.kill()
    assert not (tmp_path / "outputs" / "folder" / "run.json").exists()
    done = run_here(tmp_path, root, "cluster=sync")
    assert done.returncode == CLEAN, done.stdout + done.stderr
    assert stages(tmp_path)[after]["computed"] == 0
    assert digests(tmp_path) == digests(finished)


@pytest.mark.system
@pytest.mark.skipif(os.name != "posix", reason="process groups are POSIX")
def test_an_interrupt_says_how_to_go_on(root: Path, tmp_path: Path) -> None:
    with subprocess.Popen(
        command(tmp_path, root, "cluster=local", "cluster.workers=2"),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=tmp_path,
        start_new_session=True,
        # Where the tests run in the background, interrupts are ignored, and processes inherit that.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    ) as process:
        assert process.stdout is not None
        for line in process.stdout:
            if line.startswith("ingest") and " shapes in " in line:
                break
        os.killpg(process.pid, signal.SIGINT)  # as a terminal does: to the workers too
        _, complaint = process.communicate(timeout=120)
    assert process.returncode == INTERRUPTED
    assert "the same command goes on" in complaint and "Traceback" not in complaint


@pytest.mark.system
@pytest.mark.skipif(os.name != "posix", reason="process groups are POSIX")
@pytest.mark.parametrize("end", [signal.SIGINT, signal.SIGKILL])
def test_what_ends_a_run_ends_the_compilation_of_kernels(root: Path, tmp_path: Path, end: signal.Signals) -> None:
    with subprocess.Popen(
        command(tmp_path, root, "cluster=sync"),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=tmp_path,
        env={**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "kernels"), "PYTHONUNBUFFERED": "1"},
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    ) as process:
        assert process.stdout is not None
        lines = iter(process.stdout)
        assert any(line.startswith("compiling 1") for line in lines)  # more than nine modules
        assert any(line.startswith(("kernels", "ingest")) for line in lines)  # the first stage waits for its kernels
        compilers = psutil.Process(process.pid).children(recursive=True)
        assert compilers
        process.send_signal(end)
        process.communicate(timeout=20)
    assert process.returncode == (INTERRUPTED if end is signal.SIGINT else -end)
    _, alive = psutil.wait_procs(compilers, timeout=20)
    assert alive == []

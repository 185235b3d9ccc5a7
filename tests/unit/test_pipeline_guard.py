"""Work in a process beside the worker: what hangs or kills costs itself alone, and is told apart."""

from __future__ import annotations

import os
import select
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from pipeline.plan.work_item import WorkItem
from pipeline.runtime.guard import MAX_DEATHS, Guard, Guards
from pipeline.runtime.worker import Receipt
from pipeline.store.keys import KeyParts

LIMIT = 3.0

SCRIPTED = '''
"""Stands for pipeline.runtime.worker in the child: items do what their names say."""
import ctypes, os, time
from dataclasses import dataclass
from pathlib import Path
import pipeline.runtime.worker as real

def perform(root, items, kept):
    for item in items:
        with (Path(root) / "log").open("a") as log:
            log.write(f"{item.spec} {os.getpid()}\\n")
        if item.spec == "hang":
            ctypes.PyDLL(None).usleep(60_000_000)  # in C, with the interpreter locked, as a kernel does
        if item.spec == "crash":
            ctypes.string_at(0)
        if item.spec == "once" and not (Path(root) / "once").exists():
            (Path(root) / "once").touch()
            os.kill(os.getpid(), 9)
        yield real.Receipt(item.stage, item.key, seconds=1.0)

import pipeline.runtime.guard_process, sys
pipeline.runtime.guard_process.perform = perform
pipeline.runtime.guard_process.main(int(sys.argv[-1]))
'''


WORKER = """
import sys
import psutil
from pipeline.plan.work_item import WorkItem
from pipeline.runtime.guard import Guard
from pipeline.store.keys import KeyParts
guard = Guard(None)
lost = WorkItem(KeyParts("crs", {}, (), {}, {}), (), (("trunks", "00"),), None, (0,))  # of an input that is not there
assert len(list(guard.perform(sys.argv[1], [lost]))) == 1
(child,) = psutil.Process().children()
print(child.pid, flush=True)
sys.stdin.read()
"""
"""A worker that has a process beside it, says which, and waits."""


def item(name: str) -> WorkItem:
    return WorkItem(KeyParts("crs", {"name": name}, (), {}, {}), (), (), name, (0,))


@pytest.fixture
def scripted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    script = tmp_path / "scripted.py"
    script.write_text(SCRIPTED)
    started = subprocess.Popen

    def start(arguments: list[str], **options: object) -> subprocess.Popen[bytes]:
        return started([arguments[0], str(script), arguments[-1]], stderr=subprocess.DEVNULL, **options)  # type: ignore[call-overload,no-any-return]

    monkeypatch.setattr("pipeline.runtime.guard.subprocess.Popen", start)
    return tmp_path


def processes(folder: Path) -> list[tuple[str, str]]:
    """(item, process) of every attempt, in order."""
    return [(name, process) for name, process in map(str.split, (folder / "log").read_text().splitlines())]


def test_every_other_item_of_a_task_is_done_once(scripted: Path) -> None:
    names = ["a", "crash", "hang", "once", "b"]
    guard = Guard(LIMIT)
    receipts = list(guard.perform(str(scripted), [item(name) for name in names]))
    guard.close()
    assert [receipt.key for receipt in receipts] == [item(name).key for name in names]
    failed = {name: receipt.failure for name, receipt in zip(names, receipts, strict=True) if receipt.failure}
    assert {name: (failure.reason, failure.attempts) for name, failure in failed.items()} == {
        "crash": ("quarantined", MAX_DEATHS),
        "hang": ("time-limit", 1),
    }
    assert all(failure.deadly for failure in failed.values())
    assert "SIGSEGV" in failed["crash"].message
    assert "cluster.limit" in failed["hang"].message
    done = [name for name, _ in processes(scripted)]
    assert {name: done.count(name) for name in names} == {
        "a": 1, "crash": MAX_DEATHS, "hang": 1, "once": 2, "b": 1
    }  # fmt: skip


def test_a_guard_keeps_its_process_from_task_to_task(scripted: Path) -> None:
    guards = Guards()
    with guards.taken(None) as first:
        assert [*first.perform(str(scripted), [item("a")])] == [Receipt("crs", item("a").key, seconds=1.0)]
        with guards.taken(None) as other:
            assert other is not first
    with guards.taken(None) as again:
        assert again in (first, other)
        assert len([*again.perform(str(scripted), [item("b")])]) == 1
    (_, before), (_, after) = processes(scripted)
    assert before == after
    assert first.close() == 0 and first.close() == 0
    other.close()


def test_the_process_ends_with_its_worker(tmp_path: Path) -> None:
    """A killed worker closes nothing itself: the system does, and the child reads the end."""
    line = [sys.executable, "-c", WORKER, str(tmp_path)]
    with subprocess.Popen(line, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as worker:
        assert worker.stdout is not None
        child = int(worker.stdout.readline())
        ended = os.pidfd_open(child)
        os.kill(worker.pid, signal.SIGKILL)
        assert worker.stdout.read() == b""  # the child has it, too: it ends when both have ended
    # The end of a process closes its files first; only then is it over, which is when its descriptor can be read.
    assert select.select([ended], [], [], 60.0)[0]
    os.close(ended)

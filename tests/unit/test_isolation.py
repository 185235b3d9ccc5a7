"""Work in a process beside the worker: what hangs or crashes costs itself alone, and is told apart."""

from __future__ import annotations

import os
import select
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from pipeline.plan.work_item import WorkItem
from pipeline.runtime.isolation import IdleProcesses, IsolatedProcess
from pipeline.runtime.retries import PROCESS_TRIES
from pipeline.runtime.worker import Receipt
from pipeline.store.keys import KeyParts
from pipeline.store.store import Store

LIMIT = 3.0

SCRIPTED = '''
"""An isolated process whose items do what their specs say."""
import ctypes, os, sys
from pathlib import Path
from pipeline.runtime.isolated_process import main
from pipeline.runtime.worker import Receipt

def run_items(store, items, cache):
    for item in items:
        with (Path(store.text) / "log").open("a") as log:
            log.write(item.spec + "\\n")
        if item.spec == "hang":
            ctypes.PyDLL(None).usleep(60_000_000)  # in C, with the interpreter locked, as a kernel does
        if item.spec == "crash":
            ctypes.string_at(0)
        if item.spec == "once" and not (Path(store.text) / "once").exists():
            (Path(store.text) / "once").touch()
            os.kill(os.getpid(), 9)
        yield Receipt(item.stage, item.key, seconds=float(os.getpid()))

main(int(sys.argv[-1]), run_items)
'''


def item(name: str) -> WorkItem:
    return WorkItem(KeyParts("crs", {"name": name}, (), {}, {}), (), (), name, (0,))


@pytest.fixture
def script(tmp_path: Path) -> str:
    path = tmp_path / "scripted.py"
    path.write_text(SCRIPTED)
    return str(path)


def test_every_other_item_of_a_task_runs_once(script: str, tmp_path: Path) -> None:
    names = ["a", "crash", "hang", "once", "b"]
    process = IsolatedProcess(LIMIT, [script])
    receipts = list(process.run_items(Store(tmp_path), [item(name) for name in names]))
    process.close()
    assert [receipt.key for receipt in receipts] == [item(name).key for name in names]
    failed = {name: receipt.failure for name, receipt in zip(names, receipts, strict=True) if receipt.failure}
    assert {name: (failure.reason, failure.attempts) for name, failure in failed.items()} == {
        "crash": ("quarantined", PROCESS_TRIES),
        "hang": ("time-limit", 1),
    }
    assert all(failure.deadly for failure in failed.values())
    assert "SIGSEGV" in failed["crash"].message
    assert "cluster.limit" in failed["hang"].message
    log = (tmp_path / "log").read_text().split()
    assert {name: log.count(name) for name in names} == {
        "a": 1, "crash": PROCESS_TRIES, "hang": 1, "once": 2, "b": 1
    }  # fmt: skip


def test_a_receipt_arrives_as_soon_as_its_item_ends(script: str, tmp_path: Path) -> None:
    process = IsolatedProcess(None, [script])
    receipts = process.run_items(Store(tmp_path), [item("a"), item("hang")])
    assert next(receipts).key == item("a").key
    os.kill(process.pid, signal.SIGKILL)
    assert process.close() == -signal.SIGKILL


def test_a_process_stays_from_task_to_task_and_serves_one_at_a_time(script: str, tmp_path: Path) -> None:
    def run(process: IsolatedProcess) -> int:
        (receipt,) = process.run_items(Store(tmp_path), [item("a")])
        assert receipt == Receipt("crs", item("a").key, seconds=receipt.seconds)
        return int(receipt.seconds)

    idle = IdleProcesses(lambda limit: IsolatedProcess(limit, [script]))
    with idle.take(None) as first, idle.take(None) as second:
        pids = {run(first), run(second)}
        assert pids == {first.pid, second.pid} and len(pids) == 2
    with idle.take(None) as again:
        assert run(again) in pids
    assert first.close() == 0 and first.close() == 0
    second.close()


def test_a_process_that_is_taken_again_has_the_new_limit() -> None:
    idle = IdleProcesses()
    with idle.take(600.0) as first:
        assert first.limit == 600.0
    with idle.take(None) as again:
        assert again is first and again.limit is None


def test_the_process_ends_with_its_worker() -> None:
    """A killed worker closes nothing itself: the system does, and the process reads the end."""
    code = (
        "import sys\nfrom pipeline.runtime.isolation import IsolatedProcess\n"
        "process = IsolatedProcess(None)\nprint(process.pid, flush=True)\nsys.stdin.read()"
    )
    with subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as worker:
        assert worker.stdout is not None
        child = int(worker.stdout.readline())
        ended = os.pidfd_open(child)
        os.kill(worker.pid, signal.SIGKILL)
        assert worker.stdout.read() == b""  # the child has it, too: it ends when both have ended
    # The end of a process closes its files first; only then is it over, which is when its descriptor can be read.
    assert select.select([ended], [], [], 60.0)[0]
    os.close(ended)

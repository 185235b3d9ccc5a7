"""Ctrl-C in a terminal, at any moment of a command: exit code 130, no traceback, no process left, nothing lost."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import psutil
import pytest
from small_runs import CLEAN, INTERRUPTED, command, pictures, run_here, stages

termios = pytest.importorskip("termios", reason="terminals are POSIX")
fcntl = pytest.importorskip("fcntl")

pytestmark = pytest.mark.system

CTRL_C = b"\x03"
SECONDS_TO_END = 2.0
BUSY = 4.0
"""How many times as long it may take here, where other tests run beside it: a thread must get its turn."""


Ended = tuple[int, float, str, list[psutil.Process]]
"""Exit code of a command, seconds from the interrupt to its end, its text, and the processes that are left."""


class Terminal:
    """A command in a terminal of its own, which is the controlling one, as in a window."""

    def __init__(self, arguments: list[str], where: Path, **environment: str) -> None:
        self._ours, theirs = os.openpty()
        termios.tcsetwinsize(theirs, (40, 120))

        def take_terminal() -> None:
            fcntl.ioctl(0, termios.TIOCSCTTY, 0)
            signal.signal(signal.SIGINT, signal.default_int_handler)

        self.process = subprocess.Popen(
            arguments,
            stdin=theirs,
            stdout=theirs,
            stderr=theirs,
            cwd=where,
            env=os.environ | {"TERM": "xterm"} | environment,
            start_new_session=True,
            preexec_fn=take_terminal,
        )
        os.close(theirs)
        self._text = ""
        self._changed = threading.Condition()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        while True:
            try:
                more = os.read(self._ours, 4096)
            except OSError:  # the last process with this terminal is gone
                more = b""
            with self._changed:
                self._text += more.decode(errors="replace")
                self._changed.notify_all()
            if not more:
                os.close(self._ours)
                return

    def wait_for(self, seen: Callable[[str, psutil.Process], bool]) -> None:
        """Until the text and the process satisfy ``seen``; fails if the command ends before."""
        process, deadline = psutil.Process(self.process.pid), time.monotonic() + 200
        with self._changed:
            while not seen(self._text, process):
                assert self.process.poll() is None and time.monotonic() < deadline, self._text
                self._changed.wait(0.01)

    def press_ctrl_c(self, times: int = 1) -> Ended:
        """Press the key, which interrupts every process of the command."""
        return self._ended(lambda: os.write(self._ours, times * CTRL_C))

    def interrupt_alone(self) -> Ended:
        """Interrupt the command's own process only."""
        return self._ended(lambda: self.process.send_signal(signal.SIGINT))

    def _ended(self, interrupt: Callable[[], object]) -> Ended:
        family = psutil.Process(self.process.pid).children(recursive=True)
        pressed = time.monotonic()
        interrupt()
        code = self.process.wait(timeout=60)
        seconds = time.monotonic() - pressed
        _, left = psutil.wait_procs(family, timeout=10)
        self._reader.join(timeout=10)
        return code, seconds, self._text, left


def shows(words: str) -> Callable[[str, psutil.Process], bool]:
    return lambda text, _: words in text


def starts_workers(_: str, process: psutil.Process) -> bool:
    return any("spawn_main" in " ".join(_command_line(child)) for child in process.children())


def works(stage: str) -> Callable[[str, psutil.Process], bool]:
    """A bar of the stage is shown, and a process beside a worker is there."""
    bar = re.compile(rf"\b{stage} ")
    return lambda text, process: (
        bar.search(text) is not None
        and any("isolated_process" in " ".join(_command_line(child)) for child in process.children(recursive=True))
    )


def _command_line(process: psutil.Process) -> list[str]:
    try:
        return process.cmdline()
    except psutil.Error:
        return []


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return pictures(tmp_path_factory.mktemp("pictures"), range(24))


MOMENTS = {
    "workers start": starts_workers,
    "first stage": works("ingest"),
    "trunks": works("trunks"),
    "qcrs": works("qcrs"),
    "crs": works("crs"),
    "refine": works("refine"),
    "construct": works("construct"),
    "tables": shows("writing tables"),
    "report": shows("writing the report"),
    "end": shows("Report: "),
}
AFTER_INGEST = list(MOMENTS)[list(MOMENTS).index("trunks") : -1]


def check(ended: Ended) -> None:
    code, seconds, text, left = ended
    assert code == INTERRUPTED, text
    assert "nterrupted" in text and "Traceback" not in text, text
    assert not left
    assert seconds < BUSY * SECONDS_TO_END, f"{seconds:.1f} s"
    print(f"{seconds:.2f} s")


@pytest.mark.parametrize("moment", MOMENTS)
def test_a_run_ends_at_any_moment_and_goes_on_from_there(moment: str, root: Path, tmp_path: Path) -> None:
    terminal = Terminal(command(tmp_path, root, "cluster=local", "cluster.workers=1"), tmp_path)
    terminal.wait_for(MOMENTS[moment])
    ended = terminal.press_ctrl_c()
    if moment == "end" and ended[0] in (CLEAN, -signal.SIGINT):
        return  # the command was over before the key arrived, but for Python itself: a shell says 130 then
    check(ended)
    assert run_here(tmp_path, root, "cluster=sync").returncode == CLEAN
    if moment in AFTER_INGEST:
        assert stages(tmp_path)["ingest"]["computed"] == 0


def test_while_kernels_compile(root: Path, tmp_path: Path) -> None:
    arguments = command(tmp_path, root, "cluster=local", "cluster.workers=1")
    terminal = Terminal(arguments, tmp_path, NUMBA_CACHE_DIR=str(tmp_path / "kernels"))
    terminal.wait_for(shows("modules compiled"))
    check(terminal.press_ctrl_c())


def test_a_second_press_ends_it_at_once(root: Path, tmp_path: Path) -> None:
    terminal = Terminal(command(tmp_path, root, "cluster=local", "cluster.workers=1"), tmp_path)
    terminal.wait_for(works("refine"))
    check(terminal.press_ctrl_c(times=2))


def test_an_interrupt_of_the_run_alone_ends_all(root: Path, tmp_path: Path) -> None:
    terminal = Terminal(command(tmp_path, root, "cluster=local", "cluster.workers=1"), tmp_path)
    terminal.wait_for(works("trunks"))
    check(terminal.interrupt_alone())


def test_without_workers_it_ends_in_the_run_itself(root: Path, tmp_path: Path) -> None:
    terminal = Terminal(command(tmp_path, root, "cluster=sync"), tmp_path)
    terminal.wait_for(shows("trunks"))
    check(terminal.press_ctrl_c())


def test_while_python_loads_it_ends_at_once(root: Path, tmp_path: Path) -> None:
    terminal = Terminal(command(tmp_path, root), tmp_path)
    terminal.wait_for(lambda _, process: any("numpy" in file.path for file in process.memory_maps()))
    code, seconds, text, left = terminal.press_ctrl_c()
    assert code in (INTERRUPTED, -signal.SIGINT), text  # a shell says 130 for both
    assert seconds < BUSY * SECONDS_TO_END and not left


@pytest.mark.parametrize("name", ["make", "trunks"])
def test_commands_of_two_files_end(name: str, root: Path, tmp_path: Path) -> None:
    a, b = sorted(root.iterdir())[:2]
    output = ["-o", str(tmp_path / "out")] if name == "make" else []
    terminal = Terminal([sys.executable, "-m", "pipeline.cli.main", name, str(a), str(b), *output], tmp_path)
    terminal.wait_for(lambda _, process: any("_dispatcher" in file.path for file in process.memory_maps()))
    check(terminal.press_ctrl_c())


DROPS_THE_INTERRUPT = """
import signal, threading, weakref
from riot.cli.interrupts import interruptible

class Thing: ...

with interruptible("Interrupted."):
    thing = Thing()
    watched = weakref.ref(thing, lambda _: signal.raise_signal(signal.SIGINT))
    del thing
    print("goes on", flush=True)
    threading.Event().wait(60)
"""


def test_an_interrupt_that_python_drops_ends_it_without_a_traceback(tmp_path: Path) -> None:
    command = [sys.executable, "-c", DROPS_THE_INTERRUPT]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=50, cwd=tmp_path)
    assert (ended.returncode, ended.stdout, ended.stderr) == (INTERRUPTED, "goes on\n", "Interrupted.\n")

"""A process that has everything loaded and forks itself for each victim, so that a death costs milliseconds."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import sys
import traceback
from collections.abc import Callable, Iterator
from multiprocessing.connection import Connection
from typing import Any


class Nursery:
    """Starts victims: functions of a module, called in a process of their own, which may die of it."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection

    def start(self, victim: Callable[..., None], *arguments: Any) -> int:
        """Fork and call; returns the process's number."""
        self._connection.send(("start", victim, arguments))
        return int(self._connection.recv())

    def wait(self, pid: int) -> int:
        """How a victim ended: 0 well, 1 with an exception, −n by signal n."""
        self._connection.send(("wait", pid, ()))
        return os.waitstatus_to_exitcode(self._connection.recv())

    def call(self, victim: Callable[..., None], *arguments: Any) -> int:
        """Start and wait."""
        return self.wait(self.start(victim, *arguments))


@contextlib.contextmanager
def open_nursery() -> Iterator[Nursery]:
    """A nursery with the pipeline imported, its sources parsed and all kernels loaded."""
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_serve, args=(theirs,))
    process.start()
    try:
        ours.recv()  # loaded
        yield Nursery(ours)
    finally:
        ours.close()
        process.join()


def _serve(connection: Connection) -> None:
    import pipeline.flow
    import pipeline.report.write
    import pipeline.study.contents
    from pipeline.plan.code_digest import code_digests, library_versions
    from pipeline.stages.all import STAGES
    from pipeline.tables.record import SHOWING
    from riot.kernels.warm import warm_all

    assert pipeline.flow and pipeline.report.write and pipeline.study.contents
    warm_all(lambda text: None)
    for module in (*SHOWING, *(stage.module for stage in STAGES)):  # parsed once here, and not in every life
        code_digests(module)
        library_versions(module)
    connection.send("loaded")
    while True:
        try:
            what, subject, arguments = connection.recv()
        except EOFError:
            return
        connection.send(_fork(subject, arguments) if what == "start" else os.waitpid(subject, 0)[1])


def _fork(victim: Callable[..., None], arguments: tuple[Any, ...]) -> int:
    pid = os.fork()
    if pid:
        return pid
    code = 1
    try:
        victim(*arguments)
        code = 0
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)

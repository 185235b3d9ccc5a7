"""An executor on the workers of any Dask cluster."""

from __future__ import annotations

import contextlib
import importlib
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import CancelledError
from dataclasses import dataclass
from typing import Any

from pipeline.errors import StartError, StopError
from pipeline.runtime.admission import SECONDS_BETWEEN_LOOKS, Admission
from pipeline.runtime.clusters.executor import Bundle
from pipeline.runtime.isolation import IdleProcesses
from pipeline.runtime.retries import WORKER_LOST, WORKER_TRIES
from pipeline.runtime.worker import Failure, Receipt
from pipeline.store.store import Store
from riot.errors import MissingExtraError, needs_extra

PATIENCE = 10
"""Seconds after which missing workers are replaced, and that receipts may take to arrive."""


def run_on_worker(store: Store, bundle: Bundle, limit: float | None = None) -> list[Receipt]:
    """Run a bundle in a process beside a Dask worker (`pipeline.runtime.isolation`), an item in ``limit`` seconds.

    The idle processes are an attribute of the worker and end with it.
    """
    from distributed import get_worker

    idle = vars(get_worker()).setdefault("riot_processes", IdleProcesses())
    with idle.take(limit) as process:
        return list(process.run_items(store, bundle))


def check_dashboard() -> None:
    """Raise `StartError` where what draws Dask's dashboard is not installed."""
    if missing := missing_bokeh():
        raise StartError(f"cluster.dashboard=true: {missing}")


def missing_bokeh() -> str:
    """What to do where that is not installed with which Dask draws; empty where it is."""
    try:
        with needs_extra("dashboard"):
            importlib.import_module("bokeh")
    except MissingExtraError as error:
        return str(error)
    return ""


@contextlib.contextmanager
def scheduler_needed(client: Any) -> Iterator[None]:
    """Turn the errors of a lost scheduler into `StopError`; others pass as they are."""
    from distributed.comm import CommClosedError

    try:
        yield
    except Exception as error:
        # Without a scheduler Dask cancels the tasks, or cannot send a message; which of them, and how, is up to chance.
        is_connected = getattr(client, "status", "running") == "running"
        if is_connected and not isinstance(error, (CancelledError, CommClosedError)):
            raise
        raise StopError(
            "the connection to the Dask scheduler was lost; what is done is in the store: give the same command again "
            "once a scheduler runs"
        ) from error


def set_dask_options(*, watched: bool = True) -> None:
    """Have Dask report a lost worker to us, who count and try again; sample nothing where nobody watches."""
    import dask

    options: dict[str, Any] = {
        "distributed.scheduler.allowed-failures": 1,
        "distributed.comm.timeouts.connect": "30s",
    }
    if not watched:
        # Sampling for the dashboard takes 5 % of every worker's core, and of the scheduler's.
        options |= {
            "distributed.worker.profile.enabled": False,
            "distributed.admin.system-monitor.interval": "10s",
            "distributed.admin.tick.interval": "1s",
        }
    dask.config.set(options)


@dataclass(frozen=True)
class _Task:
    """A submitted bundle: the number of this try, and the workers that may run it; None = any."""

    bundle: Bundle
    tries: int
    workers: frozenset[str] | None


@dataclass(frozen=True)
class DaskExecutor:
    """See `pipeline.runtime.clusters.executor.Executor`: few futures at a time, with keys and receipts, no geometry.

    ``replace_workers`` is called now and then: it may start workers where some are missing. With ``admission`` only
    workers that it admits get tasks. ``most`` is how many threads there may come to be, if workers come by need.
    """

    client: Any
    task: Callable[[Store, Bundle], list[Receipt]] = run_on_worker
    replace_workers: Callable[[], None] = lambda: None
    admission: Admission | None = None
    most: int = 1

    @property
    def workers(self) -> int:
        """Threads of all workers that may get tasks, now or later."""
        with scheduler_needed(self.client):
            return max(self.most, sum(self._threads().values()))

    def _threads(self) -> dict[str, int]:
        if self.admission is not None:
            return self.admission.threads()
        return {address: int(threads) for address, threads in self.client.nthreads().items()}

    def run(self, store: Store, bundles: Sequence[Bundle]) -> Iterator[Receipt]:
        """See `Executor.run`.

        A task whose worker was lost is tried again once all others have ended, with nothing beside it, so that one
        that kills its worker takes no other with it; at last item by item. After `WORKER_TRIES` it has failed.
        """
        waiting = deque(bundles)
        suspects: deque[tuple[Bundle, int]] = deque()
        running: dict[Any, _Task] = {}

        def submit(bundle: Bundle, tries: int, threads: dict[str, int]) -> None:
            admitted = None if self.admission is None else frozenset(threads)
            name = f"{bundle[0].stage}-{bundle[0].key}-{tries}"
            workers = None if admitted is None else sorted(admitted)
            future = self.client.submit(self.task, store, tuple(bundle), key=name, pure=False, workers=workers)
            running[future] = _Task(bundle, tries, admitted)

        def fill() -> None:
            threads = self._threads()
            if self.admission is not None and not threads:
                return
            while waiting and len(running) < 2 * max(1, sum(threads.values())) + 2:
                submit(waiting.popleft(), 1, threads)
            if suspects and not running:
                submit(*suspects.popleft(), threads)

        try:
            with scheduler_needed(self.client):
                fill()
                replaced = time.monotonic()
                while running or waiting or suspects:
                    ended = self._ended(running)
                    if not ended or time.monotonic() > replaced + PATIENCE:
                        self.replace_workers()
                        replaced = time.monotonic()
                    for future in ended:
                        task = running.pop(future)
                        receipts = receipts_of(future)
                        if receipts is not None:
                            yield from receipts
                        elif task.tries + 1 < WORKER_TRIES:
                            suspects.append((task.bundle, task.tries + 1))
                        elif task.tries < WORKER_TRIES:
                            suspects.extend(([item], task.tries + 1) for item in task.bundle)
                        else:
                            failure = _failure(future, task.tries)
                            yield from (Receipt(item.stage, item.key, failure=failure) for item in task.bundle)
                        future.release()
                    fill()
        finally:
            with contextlib.suppress(OSError, RuntimeError):  # of a scheduler that is gone, and has no tasks
                self.client.cancel(list(running))

    def _ended(self, running: Mapping[Any, _Task]) -> list[Any]:
        """Wait for tasks to end; after a while without one, give those back that have no worker left."""
        from distributed import wait

        if not running:
            time.sleep(SECONDS_BETWEEN_LOOKS)
            return []
        try:
            return list(wait(list(running), timeout=PATIENCE, return_when="FIRST_COMPLETED").done)
        except TimeoutError:
            threads = self._threads()
            return [
                future
                for future, task in running.items()
                if task.workers is not None and task.workers.isdisjoint(threads)
            ]


def receipts_of(future: Any) -> list[Receipt] | None:
    """The receipts of a task that ended; None when its worker was lost before they arrived."""
    if future.status != "finished":
        return None
    try:
        # With a limit: a result lost with its worker is computed again, and without any worker never comes.
        receipts: list[Receipt] = future.result(timeout=PATIENCE)
    except Exception:  # a task raises nothing itself: this is an error of the cluster, of whatever type
        return None
    return receipts


def _failure(future: Any, tries: int) -> Failure:
    error = future.exception() if future.status == "error" else None
    if error is None:
        return Failure(WORKER_LOST, "the workers that tried it were lost", tries)
    return Failure(type(error).__name__, str(error), tries)

"""Clusters: where tasks run. One function opens any of them; all write the same bytes."""

from __future__ import annotations

import contextlib
import logging
import os
import shutil
import signal
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Protocol

from pipeline.config.schema import ClusterConfig
from pipeline.errors import StartError
from pipeline.plan.work_item import WorkItem
from pipeline.runtime.admission import Admission
from pipeline.runtime.events import Listener, Note
from pipeline.runtime.guard import Guards
from pipeline.runtime.inputs import Kept
from pipeline.runtime.threads import ONE_THREAD
from pipeline.runtime.worker import Failure, Receipt, perform
from pipeline.store.location import Location

Bundle = Sequence[WorkItem]
MAX_ATTEMPTS = 3
"""A task is tried so often when workers are lost under it."""

PATIENCE = 10
"""Seconds after which missing workers are looked for, and that receipts may take to arrive."""

BETWEEN_LOOKS = 1
"""Seconds between looks for workers while there is none."""


class Executor(Protocol):
    """Does bundles of work items in any order."""

    @property
    def workers(self) -> int:
        """How many bundles it does at once."""

    def run(self, root: str, bundles: Sequence[Bundle]) -> Iterator[Receipt]:
        """Yield the receipt of every work item as soon as it is there."""


def _say_nothing(_event: object) -> None:
    pass


@contextlib.contextmanager
def open_cluster(
    config: ClusterConfig, root: Location | None = None, listen: Listener = _say_nothing
) -> Iterator[Executor]:
    """Open the cluster that the configuration names and close it afterwards.

    Workers of a cluster beyond this machine must see the folder ``root``, the store; ``listen`` is told of those that
    are refused. Raises `StartError` when the cluster cannot be reached or none of its workers will do.
    """
    if config.kind == "sync":
        yield Here()
        return
    opened = {"local": _local, "external": _external, "slurm": _slurm}[config.kind]
    with opened(config, root, listen) as executor:
        yield executor


class Here:
    """In this process, one after another: for debugging, and as the reference. Nothing is stopped after a time."""

    workers = 1

    def __init__(self) -> None:
        self._kept = Kept()

    def run(self, root: str, bundles: Sequence[Bundle]) -> Iterator[Receipt]:
        """See `Executor.run`."""
        for bundle in bundles:
            yield from perform(root, bundle, self._kept)


def perform_on_worker(root: str, bundle: Bundle, limit: float | None = None) -> list[Receipt]:
    """Do a bundle beside a Dask worker (`pipeline.runtime.guard`), an item in at most ``limit`` seconds.

    The guards are an attribute of the worker and end with it.
    """
    from distributed import get_worker

    guards = vars(get_worker()).setdefault("riot_guards", Guards())
    with guards.taken(limit) as guard:
        return list(guard.perform(root, bundle))


@dataclass(frozen=True)
class _Task:
    """A bundle that was submitted, for which time, and the workers that may do it; None = any."""

    bundle: Bundle
    attempt: int
    among: frozenset[str] | None


@dataclass(frozen=True)
class OnDask:
    """On a Dask cluster, with a bounded window of futures: the scheduler holds keys and receipts, never geometry.

    ``revive`` is called now and then: it may start workers where some are missing. With ``admission`` only workers that
    it admits get tasks.
    """

    client: Any
    task: Callable[[str, Bundle], list[Receipt]] = perform_on_worker
    revive: Callable[[], None] = lambda: None
    admission: Admission | None = None

    @property
    def workers(self) -> int:
        """Threads of all workers that may get tasks."""
        return max(1, sum(self._threads().values()))

    def _threads(self) -> dict[str, int]:
        if self.admission is not None:
            return self.admission.threads()
        return {address: int(threads) for address, threads in self.client.nthreads().items()}

    def run(self, root: str, bundles: Sequence[Bundle]) -> Iterator[Receipt]:
        """See `Executor.run`.

        A task whose worker was lost is tried again once all others are done, with nothing beside it, so that one that
        kills its worker takes no other with it; at last item by item, and given up after `MAX_ATTEMPTS`.
        """
        waiting = deque(bundles)
        suspects: deque[tuple[Bundle, int]] = deque()
        running: dict[Any, _Task] = {}

        def submit(bundle: Bundle, attempt: int, threads: dict[str, int]) -> None:
            among = None if self.admission is None else frozenset(threads)
            name = f"{bundle[0].stage}-{bundle[0].key}-{attempt}"
            workers = None if among is None else sorted(among)
            future = self.client.submit(self.task, root, tuple(bundle), key=name, pure=False, workers=workers)
            running[future] = _Task(bundle, attempt, among)

        def fill() -> None:
            threads = self._threads()
            if self.admission is not None and not threads:
                return
            while waiting and len(running) < 2 * max(1, sum(threads.values())) + 2:
                submit(waiting.popleft(), 1, threads)
            if suspects and not running:
                submit(*suspects.popleft(), threads)

        fill()
        looked = time.monotonic()
        try:
            while running or waiting or suspects:
                ended = self._ended(running)
                if not ended or time.monotonic() > looked + PATIENCE:
                    self.revive()
                    looked = time.monotonic()
                for future in ended:
                    of = running.pop(future)
                    receipts = _receipts(future)
                    if receipts is not None:
                        yield from receipts
                    elif of.attempt + 1 < MAX_ATTEMPTS:
                        suspects.append((of.bundle, of.attempt + 1))
                    elif of.attempt < MAX_ATTEMPTS:
                        suspects.extend(([item], of.attempt + 1) for item in of.bundle)
                    else:
                        failure = _failure(future, of.attempt)
                        yield from (Receipt(item.stage, item.key, failure=failure) for item in of.bundle)
                    future.release()
                fill()
        finally:
            self.client.cancel(list(running))

    def _ended(self, running: Mapping[Any, _Task]) -> list[Any]:
        """Wait for tasks to end; after a while without one, those that no worker is left for."""
        from distributed import wait

        if not running:
            time.sleep(BETWEEN_LOOKS)
            return []
        try:
            return list(wait(list(running), timeout=PATIENCE, return_when="FIRST_COMPLETED").done)
        except TimeoutError:
            threads = self._threads()
            return [one for one, of in running.items() if of.among is not None and of.among.isdisjoint(threads)]


def _receipts(future: Any) -> list[Receipt] | None:
    """What an ended task brought back; None when its worker was lost under it, or after it with the receipts."""
    if future.status != "finished":
        return None
    try:
        # With a limit: a result lost with its worker is computed again, and without any worker never comes.
        receipts: list[Receipt] = future.result(timeout=PATIENCE)
    except Exception:  # tasks raise nothing themselves: this is the cluster, of whatever type it says it with
        return None
    return receipts


def _failure(future: Any, attempts: int) -> Failure:
    error = future.exception() if future.status == "error" else None
    if error is None:
        return Failure("WorkerLost", "the workers that tried it were lost", attempts)
    return Failure(type(error).__name__, str(error), attempts)


@contextlib.contextmanager
def _local(config: ClusterConfig, _root: Location | None, _listen: Listener) -> Iterator[Executor]:
    from distributed import Client, LocalCluster

    _quiet()
    if not config.dashboard:
        _unwatched()
    workers = config.workers or os.cpu_count() or 1
    # The terminal sends Ctrl-C to all processes, and this one alone should answer.
    with _answering_interrupts(signal.SIG_IGN):
        cluster = LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            processes=True,
            dashboard_address=":8787" if config.dashboard else ":0",  # None would try 8787 all the same
            memory_limit=0,  # a limit would kill by the machine's size, so that results would depend on it
            env=ONE_THREAD,
            silence_logs=logging.CRITICAL,
        )
    with cluster, Client(cluster) as client:
        # A worker that dies while it starts takes its nanny with it; scaling to the same size starts another.
        yield OnDask(client, partial(perform_on_worker, limit=config.limit), revive=lambda: cluster.scale(workers))


@contextlib.contextmanager
def _answering_interrupts(answer: Any) -> Iterator[None]:
    """While entered Ctrl-C is handled by ``answer``, also in processes that are started, and then again as before."""
    if threading.current_thread() is not threading.main_thread():
        yield  # signals belong to the main thread
        return
    before = signal.signal(signal.SIGINT, answer)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@contextlib.contextmanager
def _external(config: ClusterConfig, root: Location | None, listen: Listener) -> Iterator[Executor]:
    from distributed import Client

    _quiet()
    try:
        client = Client(config.address, timeout=config.wait)
    except (OSError, TimeoutError, ValueError) as error:
        raise StartError(
            f"cluster.address={config.address}: no Dask scheduler answers there ({error}); "
            "start one with `dask scheduler` and workers with `dask worker`, or use cluster=local"
        ) from error
    with client:
        yield _admitting(client, config, root, listen, f"start some with `dask worker {config.address}`")


@contextlib.contextmanager
def _slurm(config: ClusterConfig, root: Location | None, listen: Listener) -> Iterator[Executor]:
    from distributed import Client

    _quiet()
    for name in ("sbatch", "scancel"):
        if shutil.which(name) is None:
            raise StartError(f"cluster=slurm: there is no `{name}` here; start the run where Slurm jobs are submitted")
    try:
        # Once dask-jobqueue is loaded, Ctrl-C would end this process with exit code 0, as if all were done.
        with _answering_interrupts(signal.getsignal(signal.SIGINT)):
            from pipeline.runtime.slurm import Jobs, slurm_cluster
    except ImportError as error:
        raise StartError("cluster=slurm needs dask-jobqueue: pip install 'riot-shapes[slurm]'") from error
    try:
        cluster = slurm_cluster(config)
    except (OSError, RuntimeError, ValueError) as error:  # no such interface, a size that is none, a folder for logs
        raise StartError(f"cluster=slurm: {error}; conf/cluster/slurm.yaml has its parameters") from error
    with cluster, Client(cluster) as client:
        jobs = Jobs(cluster, config.jobs, lambda text: listen(Note(text)))
        jobs.submit()
        executor = _admitting(client, config, root, listen, "look at `squeue`", lambda: jobs.refusals)
        yield replace(executor, revive=jobs.submit)


def _admitting(
    client: Any,
    config: ClusterConfig,
    root: Location | None,
    listen: Listener,
    hint: str,
    refusals: Callable[[], list[str]] = list,
) -> OnDask:
    """An executor on the client's workers that will do, as soon as there is one.

    ``hint`` says how to get workers; ``refusals`` why there will be none, if that is known.
    """
    where = f"cluster.address={config.address}" if config.address else f"cluster={config.kind}"
    admission = Admission(client, root, lambda text: listen(Note(text)))
    until = time.monotonic() + config.wait
    while not admission.threads():
        if said := refusals():
            raise StartError(f"{where}: no job could be submitted: {'; '.join(said)}")
        if time.monotonic() < until:
            time.sleep(min(BETWEEN_LOOKS, config.wait / 4))
        elif admission.refusals:
            raise StartError("cluster: none of its workers will do\n  " + "\n  ".join(admission.refusals))
        else:
            raise StartError(
                f"{where}: the scheduler has no worker after {config.wait} s; {hint}, or wait longer "
                "with cluster.wait=SECONDS"
            )
    return OnDask(client, partial(perform_on_worker, limit=config.limit), admission=admission)


def _quiet() -> None:
    import dask

    # A worker that dies takes one task with it, and we try that again ourselves and count.
    dask.config.set(
        {
            "distributed.scheduler.allowed-failures": 1,
            "distributed.comm.timeouts.connect": "30s",
        }
    )


def _unwatched() -> None:
    import dask

    # Sampling for a dashboard that nobody looks at takes 5 % of every worker's core, and of the scheduler's.
    dask.config.set(
        {
            "distributed.worker.profile.enabled": False,
            "distributed.admin.system-monitor.interval": "10s",
            "distributed.admin.tick.interval": "1s",
        }
    )

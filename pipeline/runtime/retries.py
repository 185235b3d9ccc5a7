"""The one policy of retries: how often work is tried, by what failed, and which failures nothing raised."""

from __future__ import annotations

MACHINE_TRIES = 3
"""A work item is tried this often when the machine fails it (memory, files), and once when it fails by itself."""

MACHINE_FAULTS = frozenset({"OSError", "MemoryError", "BlockingIOError", "TimeoutError", "PermissionError"})
"""Types of the errors of a machine that fails."""

WORKER_TRIES = 3
"""A task is tried this often when its worker is lost: with its bundle, alone in the cluster, then item by item."""

PROCESS_TRIES = 2
"""A work item is tried this often when it ends its process, and then quarantined; beyond its time limit only once."""

TIME_LIMIT, PROCESS_LOST, WORKER_LOST = "TimeLimit", "ProcessLost", "WorkerLost"
DEADLY = frozenset({TIME_LIMIT, PROCESS_LOST, WORKER_LOST, "KilledWorker"})
"""Types of the failures that no code raised; the last is Dask's."""

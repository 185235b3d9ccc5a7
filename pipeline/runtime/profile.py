"""Dask's performance report of a run: its tasks on a line of time, by worker, and what moved between machines."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path

from pipeline.config.cluster import ClusterConfig
from pipeline.errors import StartError
from pipeline.runtime.clusters.dask_executor import missing_bokeh
from riot.errors import needs_extra

PROFILE = "profile.html"
"""The file in a run's folder."""


def check_profile(cluster: ClusterConfig) -> None:
    """Raise `StartError` where no report can be written: without Dask workers, or without what draws it."""
    if cluster.kind == "sync":
        raise StartError("--profile: cluster=sync has no Dask workers to profile; give cluster=local, or leave it away")
    if missing := missing_bokeh():
        raise StartError(f"--profile: {missing}")


@contextlib.contextmanager
def profiled(path: Path) -> Iterator[None]:
    """Write the report of what the open cluster did meanwhile; the folder is there."""
    with needs_extra("mine"):
        from distributed import performance_report

    with performance_report(filename=str(path), mode="inline"):  # it needs no network to be read
        yield

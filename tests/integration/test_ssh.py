"""``cluster=ssh``: Dask starts scheduler and workers by a real SSH server of this machine, and ends them."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest
from local_sshd import HOSTS, SSHD, ssh_home
from small_runs import BAD_START, CLEAN, command, digests

pytest.importorskip("asyncssh", reason="the extra ssh")


@pytest.fixture
def home(tmp_path: Path) -> Iterator[Path]:
    if SSHD is None or not (os.access("/run/sshd", os.W_OK) or os.getuid() == 0):
        pytest.skip("no SSH server can be started here")
    with ssh_home(tmp_path) as made:
        yield made


def mine(where: Path, root: Path, home: Path, *more: str) -> subprocess.CompletedProcess[str]:
    where.mkdir()
    return subprocess.run(
        command(where, root, "cluster=ssh", *more),
        env={**os.environ, "HOME": str(home)},
        cwd=where,
        capture_output=True,
        text=True,
        timeout=240,
    )


def started_by_ssh() -> set[int]:
    """Processes of Dask that run here for a server of SSH."""
    return {
        process.pid
        for process in psutil.process_iter(["cmdline"])
        if "distributed.cli.dask_spec" in (process.info["cmdline"] or ())
    }


@pytest.mark.system
def test_hosts_of_the_users_own_configuration_do_the_work(
    home: Path, finished: Path, root: Path, tmp_path: Path
) -> None:
    before = started_by_ssh()
    ended = mine(tmp_path / "ssh", root, home, f"cluster.hosts={','.join(HOSTS)}")
    assert ended.returncode == CLEAN, ended.stdout + ended.stderr
    assert digests(tmp_path / "ssh") == digests(finished)
    assert started_by_ssh() <= before  # nothing of it is left


@pytest.mark.system
def test_a_host_that_is_not_there_is_no_start(home: Path, root: Path, tmp_path: Path) -> None:
    ended = mine(tmp_path / "ssh", root, home, "cluster.hosts=nowhere.invalid")
    assert ended.returncode == BAD_START and "Traceback" not in ended.stderr
    assert "cluster=ssh: it cannot be started" in ended.stderr and "try `ssh HOST`" in ended.stderr

"""Certificates on every connection, as the guide shows them: real processes, and who has none is kept out."""

from __future__ import annotations

import os
import re
import subprocess
from pathlib import Path

import pytest
from dask_deployment import Deployment, kill
from distributed.security import Security
from small_runs import BAD_START, CLEAN, command, digests

from pipeline.plan.sources import ROOT

GUIDE = ROOT / "docs" / "howto" / "cluster.md"


def configuration(folder: Path) -> dict[str, str]:
    """The guide's own ``tls.yaml`` with a certificate of the moment, as Dask's configuration."""
    (block,) = re.findall(r"```yaml\n(distributed:.*?)```", GUIDE.read_text(encoding="utf-8"), flags=re.DOTALL)
    made = Security.temporary()
    files = {"ca.pem": made.tls_ca_file, "node.pem": made.tls_client_cert, "node-key.pem": made.tls_client_key}
    folder.mkdir()
    for name, text in files.items():
        (folder / name).write_text(text, encoding="ascii")
    (folder / "tls.yaml").write_text(block.replace("/etc/riot", str(folder)), encoding="utf-8")
    return {"DASK_CONFIG": str(folder)}


@pytest.mark.system
def test_a_run_with_certificates_and_none_without(finished: Path, root: Path, tmp_path: Path) -> None:
    pytest.importorskip("cryptography", reason="makes the certificate")
    variables = configuration(tmp_path / "tls")
    deployment = Deployment(tmp_path)
    try:
        deployment.start(
            *("distributed.cli.dask_scheduler", "--protocol", "tls", "--host", "127.0.0.1", "--port", "0"),
            "--no-dashboard",
            variables=variables,
        )
        deployment.workers(1, variables=variables)

        def mine(name: str, more: dict[str, str]) -> subprocess.CompletedProcess[str]:
            (tmp_path / name).mkdir()
            line = command(tmp_path / name, root, "cluster=external", f"cluster.address={address}", "cluster.wait=20")
            return subprocess.run(
                line, env={**os.environ, **more}, cwd=tmp_path, capture_output=True, text=True, timeout=240
            )

        address = deployment.written_address()
        assert address.startswith("tls://")
        ended = mine("with", variables)
        assert ended.returncode == CLEAN, ended.stderr
        assert digests(tmp_path / "with") == digests(finished)
        without = mine("without", {})
        assert without.returncode == BAD_START and "Traceback" not in without.stderr
        assert "cluster.address=tls://" in without.stderr
    finally:
        for process in reversed(deployment.started):
            kill(process)

"""The services of docker/compose.yaml, as processes of this machine: their very commands run the sample together."""

from __future__ import annotations

import contextlib
import json
import os
import shlex
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from small_runs import CLEAN, QUICK

from pipeline.plan.sources import ROOT

FILE = ROOT / "docker" / "compose.yaml"
PORTS = {"s3": "5000", "scheduler": "8786"}
"""What the services of other machines are reached by, in the file."""


def services() -> dict[str, Any]:
    return dict(yaml.safe_load(FILE.read_text(encoding="utf-8"))["services"])


def free_port() -> str:
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return str(found.getsockname()[1])


class Machine:
    """Runs services here: each host of the file is this machine, and has a port that is free."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.ports = folder, {name: free_port() for name in PORTS}
        self.running: list[subprocess.Popen[bytes]] = []

    def here(self, text: str) -> str:
        for name, port in PORTS.items():
            text = text.replace(f"{name}:{port}", f"127.0.0.1:{self.ports[name]}")
            text = text.replace(f"--port {port}", f"--port {self.ports[name]}")
        return text.replace("0.0.0.0", "127.0.0.1").replace("/outputs", str(self.folder / "outputs"))

    def command(self, service: dict[str, Any]) -> tuple[list[str], dict[str, str]]:
        program, *rest = shlex.split(self.here(service["command"]))
        settings = {name: self.here(value) for name, value in service.get("environment", {}).items()}
        path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
        return [program, *rest], {**os.environ, **settings, "PATH": path}

    def start(self, service: dict[str, Any]) -> None:
        line, environment = self.command(service)
        self.running.append(
            subprocess.Popen(line, cwd=self.folder, env=environment, stderr=subprocess.DEVNULL, start_new_session=True)
        )

    def run(self, service: dict[str, Any], *more: str) -> subprocess.CompletedProcess[str]:
        line, environment = self.command(service)
        return subprocess.run(
            [*line, *more], cwd=self.folder, env=environment, capture_output=True, text=True, timeout=280
        )


@pytest.fixture
def machine(tmp_path: Path) -> Iterator[Machine]:
    made = Machine(tmp_path)
    yield made
    for process in reversed(made.running):
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def test_no_port_is_published_and_images_are_ours() -> None:
    described = services()
    assert not [name for name, service in described.items() if "ports" in service]
    assert {service["image"] for service in described.values()} == {"riot", "riot-s3"}
    text = (FILE.parent / "Dockerfile").read_text(encoding="utf-8")
    targets = {service["build"]["target"] for service in described.values() if "build" in service}
    assert targets == {line.rpartition(" AS ")[2] for line in text.splitlines() if line.startswith("FROM")}


@pytest.mark.system
def test_the_services_mine_the_sample(machine: Machine, tmp_path: Path) -> None:
    described = services()
    for name in ("s3", "scheduler", "worker"):
        machine.start(described[name])
    until_served = (machine.run(described["bucket"]) for _ in range(20))  # restart: on-failure
    assert any(tried.returncode == 0 for tried in until_served)
    ended = machine.run(described["run"], *QUICK)
    assert ended.returncode == CLEAN, ended.stdout + ended.stderr
    assert {path.name for path in tmp_path.iterdir()} == {"outputs"}  # the store is in the bucket
    record = json.loads((tmp_path / "outputs" / "sample" / "run.json").read_bytes())
    assert record["store"] == "s3://shapes/store" and record["configuration"]["cluster"]["kind"] == "external"
    assert record["counts"]["certified"] > 0 and record["counts"]["errors"] == 0

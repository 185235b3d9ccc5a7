"""Runs that sign: real workers with the key, with another and with none; what is forged ends the next run."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from dask_deployment import Deployment, deployment
from small_runs import BAD_START, CLEAN, FAILED, command, digests, run_here

from pipeline.config.command_line import check_command, complete
from pipeline.flow import run_pipeline
from pipeline.runtime.events import Event, Note
from pipeline.store.signing import FILE
from pipeline.store.store import MANIFEST

__all__ = ["deployment"]

SECRET = "c3" * 32


def configuration(folder: Path, secret: str = SECRET) -> dict[str, str]:
    """The variable of a user whose configuration has a key."""
    (folder / "riot").mkdir(parents=True)
    (folder / "riot" / FILE).write_text(secret, encoding="ascii")
    (folder / "riot" / FILE).chmod(0o600)
    return {"XDG_CONFIG_HOME": str(folder)}


@pytest.mark.system
def test_workers_sign_and_a_forged_artifact_ends_the_run(
    deployment: Deployment, finished: Path, root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    own = configuration(tmp_path / "own")
    deployment.workers(1, variables=own)
    deployment.workers(1, variables=configuration(tmp_path / "other", "d4" * 32))
    deployment.workers(1, variables={"XDG_CONFIG_HOME": str(tmp_path / "none")})
    deployment.wait_for(3)
    monkeypatch.setenv(*next(iter(own.items())))
    where, told = tmp_path / "signed", list[str]()
    line = command(where, root, "sign=user", "cluster=external", f"cluster.address={deployment.address}")[3:]

    def listen(event: Event) -> None:
        if isinstance(event, Note):
            told.append(event.text)

    outcome = run_pipeline(check_command(complete(line)), listen)
    assert outcome.code == CLEAN, told
    refused = sorted(text.split(" is refused: ")[1][:20] for text in told if "is refused" in text)
    assert refused == ["it cannot sign: sign", "its key is another t"]
    assert digests(where) == digests(finished)
    manifests = sorted((where / "store").rglob(MANIFEST))
    assert manifests and all("signature" in json.loads(file.read_bytes()) for file in manifests)
    for file in where.rglob("*"):
        assert not file.is_file() or SECRET.encode() not in file.read_bytes(), file
    assert SECRET not in "".join(told)

    forged = next(file for file in manifests if "/ingest/" in str(file))
    manifest = json.loads(forged.read_bytes())
    forged.write_text(json.dumps({name: value for name, value in manifest.items() if name != "signature"}))
    (where / "outputs" / "folder" / "run.json").unlink()
    again = run_here(where, root, "sign=user", "cluster=sync")
    assert again.returncode == FAILED and f"not signed with the key in {tmp_path / 'own'}" in again.stderr
    assert run_here(where, root, "cluster=sync").returncode == CLEAN  # who does not ask takes it


def test_without_a_key_a_run_that_signs_does_not_start(root: Path, tmp_path: Path) -> None:
    ended = run_here(tmp_path, root, f"sign={tmp_path / 'no.key'}", "cluster=sync")
    assert ended.returncode == BAD_START and "openssl rand -hex 32" in ended.stderr
    assert not (tmp_path / "store").exists()

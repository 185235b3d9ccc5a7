"""Admission: a worker computes for a run only with the code, the libraries and the store that the run has."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

from pipeline.plan.code_digest import code_digests, library_versions
from pipeline.runtime.admission import NAMED, Admission, identity, objection
from pipeline.stages.all import STAGES
from pipeline.store.store import Store


def other(**changes: dict[str, str]) -> dict[str, Any]:
    own = identity()
    return {**own, **{part: {**own[part], **values} for part, values in changes.items()}}


def test_identity_is_what_all_stages_stand_on() -> None:
    own = identity()
    for stage in STAGES:
        assert code_digests(stage.module).items() <= own["code"].items()
        assert library_versions(stage.module).items() <= own["versions"].items()


def test_objections_name_what_differs() -> None:
    own = identity()
    assert objection(own, (own, True), Path("store")) == ""
    said = objection(own, (other(versions={"numpy": "1.0"}), True), None)
    assert "versions.numpy '1.0' →" in said and "install" in said
    assert "code.riot.scores.trunks" in objection(own, (other(code={"riot.scores.trunks": "0" * 32}), True), None)
    changed = dict.fromkeys(own["code"], "0" * 32)
    assert f"and {len(changed) - NAMED} more" in objection(own, (other(code=changed), True), None)
    assert "store=DIR" in objection(own, (own, False), Path("store"))
    assert "lacks this project" in objection(own, ModuleNotFoundError("No module named 'pipeline'"), None)
    assert "RuntimeError: odd" in objection(own, RuntimeError("odd"), None)


class Cluster:
    """A client of workers that answer as a script says; each is called whenever it is asked."""

    def __init__(self, **workers: Callable[[Any], Any]) -> None:
        self.workers = workers
        self.asked: list[list[str]] = []

    def nthreads(self) -> dict[str, int]:
        return dict.fromkeys(self.workers, 2)

    def run(self, question: Any, probe: Any, *, workers: list[str], on_error: str) -> dict[str, Any]:
        assert on_error == "return"
        self.asked.append(workers)
        return {name: self.workers[name](lambda: question(probe)) for name in workers}


def blind(ask: Callable[[], Any]) -> Any:
    theirs, _ = ask()
    return theirs, False


def test_every_worker_is_asked_once_also_one_that_joins_later(tmp_path: Path) -> None:
    told: list[str] = []
    cluster = Cluster(good=lambda ask: ask(), old=lambda ask: (other(versions={"numpy": "1.0"}), True))
    admission = Admission(cluster, Store(tmp_path), told.append)
    assert admission.threads() == {"good": 2} and admission.threads() == {"good": 2}
    cluster.workers |= {"blind": blind, "late": lambda ask: ask()}
    assert admission.threads() == {"good": 2, "late": 2}
    assert cluster.asked == [["good", "old"], ["blind", "late"]]
    assert [re.findall(r"worker (\w+) is refused", line) for line in told] == [["old"], ["blind"]]
    assert [line.split(":")[0] for line in admission.refusals] == ["blind", "old"]
    assert not list(tmp_path.iterdir())  # nothing is left of what the workers looked for


def test_workers_may_go_and_come_back(tmp_path: Path) -> None:
    told: list[str] = []

    def unreachable(ask: Callable[[], Any]) -> Any:
        return OSError("gone")

    cluster = Cluster(good=unreachable)
    admission = Admission(cluster, Store(tmp_path), told.append)
    assert admission.threads() == {} and told == []
    cluster.workers["good"] = lambda ask: ask()  # neither admitted nor refused: it is asked again
    assert admission.threads() == {"good": 2}
    cluster.workers = {}
    assert admission.threads() == {} == admission.threads()
    assert told == ["all workers have gone: waiting for others to join"]
    cluster.workers = {"good": lambda ask: (other(code={"riot.scores.trunks": ""}), True)}  # another process there
    assert admission.threads() == {} and "is refused" in told[-1]

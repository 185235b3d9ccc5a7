"""Admission: which workers of somebody else's cluster may compute for a run, asked one by one as they join.

A worker must have the code and the numeric libraries that the run's keys name, see its store, and have the key of a
store that is signed. The question travels by value, so that a worker without this project can be asked, too.
"""

from __future__ import annotations

import time
import uuid
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from pipeline.errors import StartError
from pipeline.explain.causes import explain, gather
from pipeline.plan.code_digest import code_digests, library_versions
from pipeline.stages.all import STAGES
from pipeline.store.keys import SCHEMA
from pipeline.store.location import Location
from pipeline.store.store import Store

Identity = Mapping[str, Any]
"""What all stages' keys name of code and libraries, in the form of the parts of a key."""

NAMED = 3
"""So many differences of a refused worker are named."""

SECONDS_BETWEEN_LOOKS = 1
"""Seconds between looks for workers while there is none."""


def identity() -> Identity:
    """The identity of this process."""
    code: dict[str, str] = {}
    versions: dict[str, str] = {}
    for stage in STAGES:
        code |= code_digests(stage.module)
        versions |= library_versions(stage.module)
    return {"schema": SCHEMA, "parameters": {}, "inputs": (), "code": code, "versions": versions}


class Admission:
    """The workers of a cluster: each is asked once, before it gets its first task, and admitted or refused."""

    def __init__(self, client: Any, store: Store | None, tell: Callable[[str], None]) -> None:
        """Workers must see ``store``, and have its key if it signs; ``tell`` gets a line for each that is refused."""
        self._client, self._tell = client, tell
        self._root = None if store is None else store.root
        self._signing = None if store is None else store.signing
        self._own = identity()
        self._answered: dict[str, str] = {}
        self._had_some = False

    def threads(self) -> dict[str, int]:
        """Threads of the admitted workers that are there now, by address."""
        present: dict[str, int] = self._client.nthreads()
        self._answered = {address: text for address, text in self._answered.items() if address in present}
        new = sorted(present.keys() - self._answered.keys())
        if new:
            self._ask(new)
        admitted = {address: int(count) for address, count in present.items() if self._answered.get(address) == ""}
        if self._had_some and not admitted:
            self._tell("all workers have gone: waiting for others to join")
        self._had_some = bool(admitted)
        return admitted

    def wait(self, cluster: str, seconds: float, hint: str, job_refusals: Callable[[], Sequence[str]] = tuple) -> None:
        """Wait until a worker is admitted. Raises `StartError` after ``seconds``, or when jobs are refused.

        ``cluster`` and ``hint`` tell the user where workers are missing and how to get some; ``job_refusals`` returns
        why no job can start, if that is known.
        """
        until = time.monotonic() + seconds
        while not self.threads():
            if refusals := job_refusals():
                raise StartError(f"{cluster}: no job could be submitted: {'; '.join(refusals)}")
            if time.monotonic() < until:
                time.sleep(min(SECONDS_BETWEEN_LOOKS, seconds / 4))
            elif self.refusals:
                raise StartError("cluster: none of its workers will do\n  " + "\n  ".join(self.refusals))
            else:
                raise StartError(
                    f"{cluster}: the scheduler has no worker after {seconds} s; {hint}, or wait longer "
                    "with cluster.wait=SECONDS"
                )

    @property
    def refusals(self) -> list[str]:
        """Why workers that are there now were refused, one line each."""
        return [f"{address}: {text}" for address, text in sorted(self._answered.items()) if text]

    def _ask(self, addresses: list[str]) -> None:
        with _probe(self._root) as probe:
            try:
                answers = self._client.run(_question(), probe, workers=addresses, on_error="return")
            except OSError:  # all of them are gone again; whoever is back is asked again
                return
        for address, answer in sorted(answers.items()):
            if isinstance(answer, OSError):
                continue
            text = objection(self._own, answer, self._root) or self._key_objection(address)
            self._answered[address] = text
            if text:
                self._tell(f"worker {address} is refused: {text}")

    def _key_objection(self, address: str) -> str:
        """What is wrong with the key of a worker that has this project; empty if nothing is, or nothing is signed."""
        if self._signing is None:
            return ""
        # By its answer to a question that nobody was asked before: the key stays where it is.
        challenge = uuid.uuid4().hex
        try:
            answer = self._client.run(self._signing.sign, challenge, workers=[address], on_error="return")[address]
        except OSError as error:
            answer = error
        if isinstance(answer, Exception):
            return f"it cannot sign: {answer}"
        if not self._signing.has_signed(challenge, answer):
            return f"its key is another than the one in {self._signing.path} here; give all machines the same"
        return ""


def objection(own: Identity, answer: Any, root: Location | None) -> str:
    """What is wrong with a worker that gave this answer to `_question`; empty if nothing is."""
    if isinstance(answer, ImportError):
        return f"it lacks this project or a library of it ({answer}); install there what is here"
    if isinstance(answer, Exception):
        return f"it could not say what it runs ({type(answer).__name__}: {answer}); install there what is here"
    theirs, sees = answer
    changes = explain(own, gather([theirs]))
    if theirs["code"] != own["code"] or theirs["versions"] != own["versions"] or theirs["schema"] != own["schema"]:
        rest = f" and {len(changes) - NAMED} more" if len(changes) > NAMED else ""
        return f"other code or libraries, there → here: {'; '.join(changes[:NAMED])}{rest}; install there what is here"
    if not sees:
        return f"it does not see the store {root}; share that folder, or choose one that all see with store=DIR"
    return ""


def _question() -> Callable[[str | None], tuple[Identity, bool]]:
    # A function inside a function cannot be found by name, and so is sent as it is, also where this is not installed.
    def answer(probe: str | None) -> tuple[Identity, bool]:
        from pathlib import Path

        from pipeline.runtime.admission import identity

        return identity(), probe is None or Path(probe).exists()

    return answer


@contextmanager
def _probe(root: Location | None) -> Iterator[str | None]:
    """A file in the store that was never there before, while workers look for it."""
    if not isinstance(root, Path):  # an object store is the same for all
        yield None
        return
    root.mkdir(parents=True, exist_ok=True)
    probe = root.absolute() / f".probe-{uuid.uuid4().hex}"
    probe.touch()
    try:
        yield str(probe)
    finally:
        probe.unlink(missing_ok=True)

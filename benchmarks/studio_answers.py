"""What a person waits for in the studio, asked as a browser asks: drafts, exact answers, first transforms, partners.

    python benchmarks/studio_answers.py PICTURES                 pairs of pictures of a folder, sixteen of them
    python benchmarks/studio_answers.py PICTURES --pairs 40      more of them
    python benchmarks/studio_answers.py PICTURES --in RUN        partners in a finished run, too

A server runs in a process of its own. Every time is from the moment a message is sent to the moment its answer has
come, wall-clock, JSON and all; beside it stands the CPU time of computing the answer. Edits are those of a person: a
boundary point pulled in small steps, a trunk corner moved, the weight of bending dragged.
"""

from __future__ import annotations

import argparse
import http.client
import json
import math
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Origin

ROOT = Path(__file__).resolve().parents[1]
SUFFIXES = (".png", ".svg")
MOVES = 12
"""Steps of a drag."""

REACH, STEP = 0.12, 0.004
"""Of a pull, and how far the pointer moves between two messages, in the unit-area frame."""

TARGETS = {
    "page": 1000.0,
    "first transform": 2000.0,
    "best transform": 2000.0,
    "draft": 100.0,
    "exact": 500.0,
    "partners": 1000.0,
}
"""Milliseconds that the design asks for, by the beginning of what is measured."""

Times = defaultdict[str, list[float]]


class Browser:
    """Asks a server as a tab does."""

    def __init__(self, address: str) -> None:
        """Open the studio by the address that it printed."""
        self.origin, token = address.split("/?token=")
        self.host = self.origin.removeprefix("http://")
        self.cookie = ""
        self.cookie = self.ask("GET", f"/?token={token}").headers["set-cookie"].split(";")[0]
        self.seq = 0

    def ask(self, method: str, path: str, body: bytes | None = None) -> http.client.HTTPResponse:
        """An HTTP request; the answer is read with `read`."""
        connection = http.client.HTTPConnection(self.host)
        connection.request(method, path, body, {"origin": self.origin, "cookie": self.cookie})
        return connection.getresponse()

    def tab(self, session: str) -> ClientConnection:
        """A tab's connection."""
        return connect(
            f"ws://{self.host}/ws/{session}",
            origin=Origin(self.origin),
            additional_headers={"cookie": self.cookie},
            max_size=None,
            compression=None,
        )

    def answer(self, tab: ClientConnection, **request: Any) -> tuple[dict[str, Any], float]:
        """The answer to a request, and how long it took, in milliseconds."""
        self.seq += 1
        started = time.perf_counter()
        tab.send(json.dumps({**request, "seq": self.seq}))
        answer = until(tab, ("transform", "problem", "refused", "partners"), self.seq)
        return answer, 1e3 * (time.perf_counter() - started)


def until(tab: ClientConnection, kinds: Sequence[str], seq: int) -> dict[str, Any]:
    """The next message of these kinds with this number."""
    while True:
        message: dict[str, Any] = json.loads(tab.recv(timeout=120))
        if message["type"] in kinds and message["seq"] == seq:
            return message


def measure_pair(browser: Browser, pictures: Sequence[Path], times: Times, cpu: Times, counts: dict[str, int]) -> None:
    """Drop two pictures and edit what comes."""
    session = json.loads(browser.ask("POST", "/api/sessions").read())["id"]
    with browser.tab(session) as tab:
        until(tab, ("session",), 0)
        started = time.perf_counter()
        for side, path in zip("pq", pictures, strict=True):
            browser.ask("PUT", f"/api/sessions/{session}/input/{side}?name=a", path.read_bytes()).read()
        message = until(tab, ("transform", "problem"), 0)
        if message["type"] == "problem":
            counts["pairs without a transform"] += 1
            return
        times["first transform"].append(1e3 * (time.perf_counter() - started))
        cpu["first transform"].append(message["cpu"])
        while message["draft"]:
            message = until(tab, ("transform",), 0)
        cpu["best transform"].append(message["cpu"])
        times["best transform"].append(1e3 * (time.perf_counter() - started))
        for kind, edits in drags(message["scene"]).items():
            for edit in edits:
                answer, took = browser.answer(tab, type="edit", phase="move", edit=edit)
                times[f"draft: {kind}"].append(took)
                cpu[f"draft: {kind}"].append(answer.get("cpu", math.nan))
                counts[f"{kind}: {answer['type']}"] += 1
            answer, took = browser.answer(tab, type="edit", phase="release", edit=edits[-1])
            times[f"exact: {kind}"].append(took)
            cpu[f"exact: {kind}"].append(answer.get("cpu", math.nan))
            if answer["type"] == "transform":
                browser.answer(tab, type="undo")


def drags(scene: dict[str, Any]) -> dict[str, list[dict[str, Any]]]:
    """The edits of each drag, from its first step to its last."""
    side = scene["p"]
    points = np.array(side["bent"] or side["input"]).reshape(-1, 2)
    at, corner = points[len(points) // 3], np.array(side["feet"]).reshape(-1, 2)[1]
    away = at / np.hypot(*at)
    place = int(np.argmin(np.hypot(*(points - corner).T)))
    pulls = [(at + STEP * k * away).tolist() for k in range(1, MOVES + 1)]
    moves = [points[(place + k) % len(points)].tolist() for k in range(1, MOVES // 2)]
    return {
        "pull": [{"kind": "pull", "side": "p", "at": at.tolist(), "to": to, "reach": REACH} for to in pulls],
        "keep": [{"kind": "keep", "side": "p", "points": at.tolist()}],
        "corner": [{"kind": "corner", "side": "p", "corner": 1, "to": to} for to in moves],
        "weight": [{"kind": "weight", "weight": round(1.0 + 0.1 * k, 1)} for k in range(1, MOVES // 2)],
    }


def measure_partners(browser: Browser, times: Times) -> int:
    """Ask for partners of shapes of the collection; returns how many shapes it has."""
    shapes = len(json.loads(browser.ask("GET", "/api/collection").read())["shapes"])
    session = json.loads(browser.ask("POST", "/api/sessions").read())["id"]
    with browser.tab(session) as tab:
        until(tab, ("session",), 0)
        for number in np.linspace(0, shapes - 1, 24).astype(int).tolist():
            _, took = browser.answer(tab, type="partners", shape=number)
            times["partners"].append(took)
            browser.answer(tab, type="partners")  # ends the previews
    return shapes


def measure_page(browser: Browser, times: Times) -> int:
    """Load the page; returns the bytes of it and of what it names."""
    started, size, names = time.perf_counter(), 0, ["/"]
    for name in names:
        data = browser.ask("GET", name).read()
        size += len(data)
        for word in data.decode("utf-8", "replace").split('"'):
            if word.startswith("/static/") and word not in names:
                names.append(word)
    times["page"].append(1e3 * (time.perf_counter() - started))
    return size


@contextmanager
def server(folder: str, run: Path | None) -> Iterator[Browser]:
    """A studio in a process of its own."""
    command = [sys.executable, "-m", "pipeline.cli.main", "studio", "--no-browser", "--folder", folder]
    if run is not None:
        command += ["--in", str(run.resolve())]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=ROOT) as process:
        assert process.stdout is not None
        try:
            yield Browser(process.stdout.readline().split()[-1])
        finally:
            process.terminate()


def show(times: Times, cpu: Times, notes: Sequence[str]) -> None:
    """Print the distributions."""
    table = Table(
        "what", "times", "median ms", "p95", "greatest", "target", "CPU median", "CPU p95", title="The studio"
    )
    for name, values in times.items():
        median, high = np.percentile(values, [50, 95])
        target = next((most for start, most in TARGETS.items() if name.startswith(start)), None)
        shown = "" if target is None else f"{target:.0f} {'met' if high <= target else 'missed'}"
        computed = [f"{value:.0f}" for value in np.nanpercentile(cpu[name], [50, 95])] if name in cpu else ["", ""]
        table.add_row(name, str(len(values)), f"{median:.0f}", f"{high:.0f}", f"{max(values):.0f}", shown, *computed)
    console = Console(width=110)
    console.print(table)
    for note in notes:
        console.print(note)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pictures", type=Path)
    parser.add_argument("--pairs", type=int, default=16)
    parser.add_argument("--in", dest="run", type=Path)
    chosen = parser.parse_args()
    paths = sorted(path for path in chosen.pictures.rglob("*") if path.suffix.lower() in SUFFIXES)
    picked = [paths[k] for k in np.random.default_rng(0).choice(len(paths), 2 * chosen.pairs, replace=False)]
    times, cpu, counts, notes = Times(list), Times(list), defaultdict[str, int](int), list[str]()
    with tempfile.TemporaryDirectory() as folder, server(folder, chosen.run) as browser:
        warm_up(browser, picked[:2])
        notes.append(f"page: {measure_page(browser, times)} bytes")
        for pair in zip(picked[::2], picked[1::2], strict=True):
            measure_pair(browser, pair, times, cpu, counts)
        if chosen.run is not None:
            notes.append(f"partners: in {measure_partners(browser, times)} shapes")
    show(times, cpu, [*notes, ", ".join(f"{name}: {count}" for name, count in sorted(counts.items()))])


def warm_up(browser: Browser, pictures: Sequence[Path]) -> None:
    """The first pair waits for what the workers load; it does not count."""
    measure_pair(browser, pictures, Times(list), Times(list), defaultdict(int))


if __name__ == "__main__":
    main()

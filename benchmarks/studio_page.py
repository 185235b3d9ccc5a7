"""What the studio's page costs in a browser: its weight, how soon it is there, and frames a second while pieces swing.

    python benchmarks/studio_page.py A B                 of two pictures
    python benchmarks/studio_page.py A B --in RUN        with the wall of a finished run

A server and a headless Chromium run on this machine. Wall-clock times of several loads; the first is cold. Beside
frames a second stands how busy the main thread is: above 100 % frames would be lost.
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

LOADS = 5
SECONDS = 5.0
"""Of swinging."""

WEIGHT = """() => {
    const all = [...performance.getEntriesByType('navigation'), ...performance.getEntriesByType('resource')];
    return [all[0].loadEventEnd, all.reduce((sum, one) => sum + one.decodedBodySize, 0),
            all.reduce((sum, one) => sum + one.encodedBodySize, 0), all.length];
}"""
FRAMES = """milliseconds => new Promise(done => {
    const times = [], start = performance.now();
    const frame = now => {
        times.push(now);
        if (now - start < milliseconds) requestAnimationFrame(frame);
        else done(times);
    };
    requestAnimationFrame(frame);
})"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pictures", type=Path, nargs=2, metavar="PICTURE")
    parser.add_argument("--in", dest="run_folder", type=Path, metavar="RUN")
    chosen = parser.parse_args(arguments)
    table = Table("what", "measured", "target")
    more = [] if chosen.run_folder is None else ["--in", str(chosen.run_folder)]
    with tempfile.TemporaryDirectory() as folder, _studio(folder, more) as address, _browser() as browser:
        page = browser.new_page(viewport={"width": 1280, "height": 800})
        loads = [_load(page, address) for _ in range(LOADS)]
        times = ", ".join(f"{load[0]:.0f}" for load in loads)
        table.add_row("page load, ms", times, "≤ 1000")
        _, plain, sent, requests = loads[-1]
        table.add_row("page, kB", f"{plain / 1000:.0f} in {requests:.0f} files, {sent / 1000:.0f} as sent", "≤ 500")
        for side, picture in zip("pq", chosen.pictures, strict=True):
            page.set_input_files(f"#file-{side}", picture)
        page.wait_for_url("**/*#look")
        page.locator("#certificate", has_text="certified exact").wait_for()
        pieces = page.locator("[data-view=chain] [data-piece]").count()
        gaps, busy = _swing(page)
        words = f"{1000 / gaps.mean():.1f}, main thread {100 * busy:.0f} % busy"
        table.add_row(f"frames a second, {pieces} pieces", words, "60")
        table.add_row("longest 5 % of frames, ms", f"{np.percentile(gaps, 95):.1f} to {gaps.max():.1f}", "≤ 17")
    Console().print(table)
    return 0


def _load(page: Any, address: str) -> list[float]:
    page.goto(address)
    page.locator("#saved", has_text="Saved").wait_for()
    answer: list[float] = page.evaluate(WEIGHT)
    return answer


def _swing(page: Any) -> tuple[Any, float]:
    """Milliseconds between frames, and the share of the time that the main thread works."""
    session = page.context.new_cdp_session(page)
    session.send("Performance.enable")

    def worked() -> float:
        metrics = session.send("Performance.getMetrics")["metrics"]
        return float(next(metric["value"] for metric in metrics if metric["name"] == "TaskDuration"))

    before = worked()
    times = page.evaluate(FRAMES, 1000 * SECONDS)
    return np.diff(times), (worked() - before) / SECONDS


@contextmanager
def _studio(folder: str, more: Sequence[str]) -> Iterator[str]:
    """The address of a studio that runs meanwhile."""
    command = [sys.executable, "-m", "pipeline.cli.main", "studio", "--no-browser", "--folder", folder, *more]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        yield process.stdout.readline().split()[-1]
        process.terminate()


@contextmanager
def _browser() -> Iterator[Any]:
    from playwright.sync_api import sync_playwright

    chromium = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if chromium is None:
        sys.exit("there is no Chromium on this machine: install chromium")
    with sync_playwright() as api:
        browser = api.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        yield browser
        browser.close()


if __name__ == "__main__":
    sys.exit(main())

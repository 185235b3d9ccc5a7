"""What a command takes to start, and what making and printing take, beside the start of Python and of NumPy.

    python benchmarks/start.py                      help, show, make, print, a plan, a finished run again
    python benchmarks/start.py --run OUTPUTS        a finished run again, too: the folder of its tables (outputs/mpeg7)
    python benchmarks/start.py --processes 9        more processes of each (default: 5)

Each command runs in several processes, one after another in rounds, so that a busy moment of the machine strikes all
alike. CPU time is that of the process and of those that it starts. The last rows are the digests of all stages, which
each run takes of its own code: from an empty cache of parsed files, and from a full one.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageDraw
from rich import box
from rich.console import Console
from rich.table import Table

from pipeline.stages.all import STAGES
from riot.draw.ffmpeg import film_writer
from riot.errors import MissingExtraError
from riot.groundtruth.pairs import exact_pair, exact_transform
from riot.motion.planner import with_motion
from riot.transform.riot_file import save

ROOT = Path(__file__).resolve().parents[1]
PROGRAM = ("-m", "pipeline.cli.main")
WIDTH = 140
PICTURES = 8

DIGESTS = """
import sys
from pathlib import Path
from pipeline.plan import code_digest
from pipeline.plan.closure import Project
from pipeline.plan.module_facts import FactsCache
from pipeline.plan.sources import AT_START, PACKAGES
if sys.argv[1]:
    code_digest.PROJECT = Project(AT_START, FactsCache(PACKAGES, Path(sys.argv[1])))
for module in sys.argv[2:]:
    code_digest.code_digests(module)
    code_digest.library_versions(module)
"""


@dataclass(frozen=True)
class Start:
    """A command: its name in the table, the arguments of Python, where it runs, and what it may take, in seconds."""

    name: str
    arguments: tuple[str, ...]
    folder: Path = ROOT
    target: str = ""


@dataclass(frozen=True)
class Times:
    """CPU and wall seconds of the processes of one command."""

    cpu: list[float]
    wall: list[float]

    @property
    def figures(self) -> dict[str, float]:
        """Least and median of both."""
        return {
            "cpu_min": min(self.cpu),
            "cpu_median": statistics.median(self.cpu),
            "wall_min": min(self.wall),
            "wall_median": statistics.median(self.wall),
        }


def time_process(start: Start) -> tuple[float, float]:
    """CPU and wall seconds of a fresh process; raises RuntimeError with what it said if it fails."""
    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    command = [sys.executable, *start.arguments]
    # The checkout is found from any folder.
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(command, cwd=start.folder, env=environment, capture_output=True, text=True)
    wall, after = time.perf_counter() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode not in (0, 3, 4):  # 4: done, but two drawn pictures need not be alike
        raise RuntimeError(f"{start.name}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, wall


def time_starts(starts: Sequence[Start], processes: int) -> dict[str, Times]:
    """The times of ``processes`` rounds over all commands, after one that is not counted."""
    times = {start.name: Times([], []) for start in starts}
    for number in range(processes + 1):
        for start in starts:
            cpu, wall = time_process(start)
            if number:
                times[start.name].cpu.append(cpu)
                times[start.name].wall.append(wall)
    return times


def small_folder(folder: Path) -> tuple[str, ...]:
    """Draw few pictures; returns the command that mines them into the same folder."""
    pictures = folder / "pictures"
    pictures.mkdir()
    for number in range(PICTURES):
        rng = np.random.default_rng(number)
        turns = 2.0 * np.pi * (np.arange(4 + number % 4) + 0.3 * rng.random(4 + number % 4)) / (4 + number % 4)
        reach = 60.0 + 25.0 * rng.random(len(turns))
        image = Image.new("L", (200, 200))
        corners = np.column_stack([100.0 + reach * np.cos(turns), 100.0 + reach * np.sin(turns)])
        ImageDraw.Draw(image).polygon([(x, y) for x, y in corners.tolist()], 255)
        image.save(pictures / f"kind{number % 3}-{number}.png")
    selection = ("select.top=3", "select.breadth=2", "batch=4")
    return (*PROGRAM, "mine", "+dataset=folder", "dataset.root=pictures", *selection)


def making(folder: Path) -> list[Start]:
    """The commands that make a transform of two pictures of `small_folder`, film it, and make its puzzle."""
    exact, made = str(folder / "exact.riot"), (*PROGRAM, "make", "pictures/kind0-0.png", "pictures/kind1-1.png")
    printed = (*PROGRAM, "print", exact, "--force", "--size", "150")
    films = [
        Start("riot make A B --mp4", (*made, "-o", "filmed", "--force", "--mp4"), folder),
        Start("riot show FILE --film FILM.mp4", (*PROGRAM, "show", exact, "--film", "film.mp4"), folder, "4 CPU"),
    ]
    try:
        film_writer()
    except MissingExtraError as error:
        print(f"films are not measured: {error}", file=sys.stderr)
        films = []
    return [
        Start("riot make A B", (*made, "-o", "made", "--force"), folder, "3 CPU"),
        *films,
        Start("riot print FILE", (*printed, "-o", "printed"), folder, "5 CPU"),
        Start("riot print FILE --paper", (*printed, "-o", "papers", "--paper"), folder, "5 CPU"),
        Start("riot print FILE --inlay 0.6", (*printed, "-o", "inlaid", "--inlay", "0.6"), folder, "5 CPU"),
    ]


def command_again(tables: Path) -> tuple[tuple[str, ...], Path]:
    """The command that finds a finished run finished, and the folder where it runs; ``tables``: `outputs/mpeg7`."""
    record = json.loads((tables / "run.json").read_text(encoding="utf-8"))
    configuration = {**record["configuration"], "store": record["store"], "outputs": str(tables.parent)}
    arguments = (*PROGRAM, "mine", *(f"{name}={value}" for name, value in _plain(configuration)))
    planned = subprocess.run([sys.executable, *arguments, "--plan", "--json"], cwd=ROOT, capture_output=True, text=True)
    stages = json.loads(planned.stdout)["stages"] if planned.returncode == 0 else []
    if not stages or any(stage["to_do"] != 0 for stage in stages):
        raise SystemExit(
            f"{tables}: no run that is finished with this code{planned.stderr and chr(10)}{planned.stderr}"
        )
    return arguments, ROOT


def _plain(config: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, str]]:
    """Names and values as a command line has them."""
    for name, value in config.items():
        if isinstance(value, Mapping):
            yield from _plain(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", "null" if value is None else json.dumps(value)


def show(times: Mapping[str, Times], targets: Mapping[str, str], console: Console) -> None:
    """Print the table: seconds, and the ratios of the least CPU times to those of the first two rows."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("start", no_wrap=True)
    for name in ("CPU s: min", "median", "wall s: min", "median", "× pass", "× numpy"):
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column("target")
    references = [entry.figures["cpu_min"] for entry in list(times.values())[:2]]
    for name, entry in times.items():
        ratios = [f"{entry.figures['cpu_min'] / reference:.1f}" for reference in references]
        table.add_row(name, *(f"{value:.3f}" for value in entry.figures.values()), *ratios, targets[name])
    console.print(table)


def main() -> None:
    """Print the table, and write the figures as JSON if that is wanted."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--processes", type=int, default=5, help="processes of each command (default: %(default)s)")
    parser.add_argument(
        "--run", type=Path, metavar="OUTPUTS", help="the tables of a finished run, such as outputs/mpeg7"
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures, too")
    chosen = parser.parse_args()
    modules = [stage.module for stage in STAGES]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        save(with_motion(exact_transform(exact_pair(4, 3))), folder / "exact.riot")
        again = small_folder(folder)
        starts = [
            Start("python -c pass", ("-c", "pass")),
            Start("python -c 'import numpy'", ("-c", "import numpy")),
            Start("python -c 'import riot'", ("-c", "import riot")),
            Start("riot --help", (*PROGRAM, "--help"), target="0.3 wall"),
            Start("riot show FILE", (*PROGRAM, "show", str(folder / "exact.riot")), target="0.7 wall"),
            Start("riot show FILE --verbose", (*PROGRAM, "show", str(folder / "exact.riot"), "--verbose")),
            *making(folder),
            Start("riot mine --help", (*PROGRAM, "mine", "--help")),
            Start("python -m pipeline.run --plan", ("-m", "pipeline.run", "--plan"), folder, "1.5 CPU"),
            Start(f"a finished run of {PICTURES} pictures again", again, folder),
        ]
        if chosen.run is not None:
            arguments, where = command_again(chosen.run.resolve())
            starts.append(Start(f"the finished run {chosen.run.name} again", arguments, where, "4 CPU"))
        fresh = ("-c", "import sys; from pathlib import Path; Path(sys.argv[1]).unlink(missing_ok=True)\n" + DIGESTS)
        starts.append(Start("digests of all stages, nothing parsed", (*fresh, str(folder / "facts.json"), *modules)))
        starts.append(Start("digests of all stages, all known", ("-c", DIGESTS, str(folder / "facts.json"), *modules)))
        times = time_starts(starts, chosen.processes)
    console = Console(highlight=False)
    show(
        times, {start.name: start.target for start in starts}, console if console.is_terminal else Console(width=WIDTH)
    )
    if chosen.json is not None:
        figures = {start.name: times[start.name].figures for start in starts}
        chosen.json.write_text(
            json.dumps({"processes": chosen.processes, "starts": figures}, indent=1), encoding="utf-8"
        )


if __name__ == "__main__":
    main()

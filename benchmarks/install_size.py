"""What an installation brings: the packages of the base and of extras, with their sizes, in a fresh environment.

``python benchmarks/install_size.py [--extras mine print] [--source DIR]`` makes a virtual environment, installs the
project with the versions of constraints.txt, and measures the files of every distribution: first of the base, then what
each extra adds to what is there. ``--source`` is a checkout of another version, to compare with.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
OURS = "riot-shapes"

SIZES = """
import json
from importlib import metadata
sizes = {}
for distribution in metadata.distributions():
    paths = {path.locate().resolve() for path in distribution.files or ()}
    sizes[distribution.metadata["Name"]] = sum(path.stat().st_size for path in paths if path.is_file())
print(json.dumps(sizes))
"""


@dataclass(frozen=True)
class Step:
    """An installation: what pip was asked for, the bytes of each distribution that it added, and its seconds."""

    name: str
    added: dict[str, int]
    seconds: float


def installed_sizes(python: Path) -> dict[str, int]:
    """Bytes of the files of each distribution in the environment of ``python``."""
    done = subprocess.run([python, "-c", SIZES], capture_output=True, text=True, check=True)
    sizes: dict[str, int] = json.loads(done.stdout)
    return sizes


def install(python: Path, source: Path, extra: str) -> Step:
    """Install the project with an extra (empty: without), and measure what that adds."""
    before = installed_sizes(python)
    target = f"{source}[{extra}]" if extra else str(source)
    options = ["--quiet", "--disable-pip-version-check", "--constraint", str(source / "constraints.txt")]
    started = time.perf_counter()
    subprocess.run([python, "-m", "pip", "install", *options, target], check=True)
    seconds = time.perf_counter() - started
    added = {name: size for name, size in installed_sizes(python).items() if name not in before}
    return Step(extra or "base", added, seconds)


def main() -> None:
    """Print a table for the base and one for each extra."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--extras", nargs="*", default=["mine"], help="extras to add, in this order (default: mine)")
    parser.add_argument("--source", type=Path, default=ROOT, help="the checkout to install (default: this one)")
    chosen = parser.parse_args()
    total, count = 0, 0
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([sys.executable, "-m", "venv", folder], check=True)
        python = Path(folder, "bin", "python")
        for extra in ("", *chosen.extras):
            step = install(python, chosen.source.resolve(), extra)
            added = {name: size for name, size in step.added.items() if name != OURS}
            total, count = total + sum(added.values()), count + len(added)
            print(f"{step.name}: {len(added)} packages, {sum(added.values()) / 1e6:.0f} MB, {step.seconds:.0f} s")
            for name, size in sorted(added.items(), key=lambda entry: -entry[1]):
                print(f"{size / 1e6:9.1f} MB  {name}")
    print(f"in all: {count} packages, {total / 1e6:.0f} MB")


if __name__ == "__main__":
    main()

"""What it costs to compile the kernels: CPU seconds, objects and bytes by module.

``python benchmarks/compile.py [MODULE …] [--repeats 1] [--root FOLDER]`` compiles every kernel module, or those named,
in a process of its own and into an empty cache. ``--root`` measures another checkout with the same environment.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]

COMPILE = """
import importlib, sys, time
module = importlib.import_module(f"riot.kernels.{sys.argv[1]}")
began = time.process_time()
module.warm()
print(time.process_time() - began)
"""

NO_KERNELS = {"__init__", "forest", "options", "warm"}


@dataclass(frozen=True)
class Cost:
    """What one module costs: CPU seconds of `warm`, files of machine code and their bytes."""

    module: str
    seconds: float
    objects: int
    size: int


def kernel_modules(root: Path) -> list[str]:
    """The names of the modules with kernels."""
    return sorted(path.stem for path in (root / "riot" / "kernels").glob("*.py") if path.stem not in NO_KERNELS)


def cost(module: str, root: Path, repeats: int) -> Cost:
    """Compile one module ``repeats`` times; the least time counts."""
    seconds = []
    for _ in range(repeats):
        with tempfile.TemporaryDirectory() as cache:
            environment = {**os.environ, "NUMBA_CACHE_DIR": cache, "PYTHONPATH": str(root)}
            done = subprocess.run(
                [sys.executable, "-c", COMPILE, module],
                cwd=root, env=environment, capture_output=True, text=True, check=True,
            )  # fmt: skip
            seconds.append(float(done.stdout))
            sizes = [path.stat().st_size for path in Path(cache).rglob("*.nbc")]
    return Cost(module, min(seconds), len(sizes), sum(sizes))


def main() -> None:
    """Print a row for each module, the slowest first, and the sum."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("modules", nargs="*", help="kernel modules (default: all)")
    parser.add_argument("--repeats", type=int, default=1, help="compilations of each module (default: 1)")
    parser.add_argument("--root", type=Path, default=ROOT, help="checkout to measure (default: this one)")
    options = parser.parse_args()
    modules = options.modules or kernel_modules(options.root)
    costs = [cost(module, options.root.resolve(), options.repeats) for module in modules]
    costs.sort(key=lambda each: -each.seconds)
    total = Cost("all", *(sum(values) for values in zip(*((c.seconds, c.objects, c.size) for c in costs), strict=True)))
    print(f"{'module':12} {'CPU s':>7} {'objects':>8} {'MB':>6}")
    for line in [*costs, total]:
        print(f"{line.module:12} {line.seconds:7.1f} {line.objects:8d} {line.size / 1e6:6.2f}")


if __name__ == "__main__":
    main()

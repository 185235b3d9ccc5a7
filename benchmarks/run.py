"""What each step of the method costs on this machine, beside the paper's times, targets, references and floors.

    python benchmarks/run.py                          exact pairs, rendered to pictures
    python benchmarks/run.py --size small             the same in seconds
    python benchmarks/run.py --root DIR --shapes 60   pictures from a folder and its sub-folders, evenly chosen

CPU time of one core, kernels compiled beforehand, of several rounds each item's least. Where a slower way to the same
result is known, it runs too, on the same input: the two must agree (exit code 1 if they do not) and the ratio of their
times says what the faster way is worth. Times depend on the machine; ratios, counts and distances from the floor
hardly do. Floors are counts over rates that small probes measure in the same run (see floors.py).
"""

from __future__ import annotations

import pipeline.runtime.threads  # noqa: F401  (before anything that loads a numeric library)

# ruff: isort: split
import argparse
import json
import os
import platform
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np
from dataflow import dataflow_steps
from floors import measure_rates
from inputs import SIZES, pictures, render
from pair_steps import cross_steps, quick_steps
from shape_steps import shape_steps
from table import show, to_json

from riot.kernels.warm import warm_all

FORMAT = 2
"""Version of the JSON."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run, print the table, write JSON if asked; 1 if a fast way and its reference disagree."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--size", choices=SIZES, default="medium")
    parser.add_argument("--root", type=Path, help="a folder of pictures instead of exact pairs")
    parser.add_argument("--shapes", type=int, help="number of shapes instead of the size's")
    parser.add_argument("--json", type=Path, help="write the figures to this file too")
    chosen = parser.parse_args(arguments)
    size = SIZES[chosen.size]
    count = chosen.shapes or size.shapes

    warm_all(_say)
    rates = measure_rates()
    with tempfile.TemporaryDirectory() as folder:
        many = max(count, chosen.shapes or size.flow_shapes)
        rendered = [] if chosen.root else render(many, Path(folder))
        paths = pictures(chosen.root, count) if chosen.root else rendered[:count]
        if len(paths) < 2:
            parser.error(f"fewer than two pictures under {chosen.root}")
        _say(f"{len(paths)} shapes …")
        shape_rows, shapes = shape_steps(paths, size, rates)
        _say("QCRS …")
        quick_rows, ranked = quick_steps(shapes.quick, size, rates)
        _say("CRS and construction …")
        cross_rows = cross_steps(shapes, ranked, size, rates)
        _say("dataflow …")
        flow_rows = dataflow_steps(pictures(chosen.root, many) if chosen.root else rendered, size)
    rows = [*shape_rows, *quick_rows, *cross_rows, *flow_rows]
    show(rows)
    if chosen.json:
        document = {
            "format": FORMAT,
            "source": "folder" if chosen.root else "exact pairs",
            "size": chosen.size,
            "machine": _machine(),
            "rates": asdict(rates),
            "steps": to_json(rows),
        }
        chosen.json.write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    wrong = [row.step for row in rows if row.agree is False]
    if wrong:
        _say(f"not the same as the reference: {', '.join(wrong)}")
    return 1 if wrong else 0


def _say(message: str) -> None:
    print(message, file=sys.stderr)


def _machine() -> dict[str, object]:
    import numba

    return {
        "cpus": os.cpu_count(),
        "processor": platform.machine(),
        "python": platform.python_version(),
        "numpy": np.__version__,
        "numba": numba.__version__,
    }


if __name__ == "__main__":
    sys.exit(main())

"""The time of each step in a run, compared with the paper's table of times."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from pipeline.study import plots
from pipeline.study.findings import Findings, Sheet, of_columns
from pipeline.study.finished import StudiedRun
from pipeline.tables.schemas import column
from riot.errors import needs_extra
from riot.parameters.field import ParameterGroup

with needs_extra("mine"):
    import pyarrow as pa


@dataclass(frozen=True)
class Parameters(ParameterGroup):
    """There are none."""


@dataclass(frozen=True)
class MethodStep:
    """A row of the paper's table: the stages that do the same here, the paper's seconds an item, and what an item is.

    The paper ran MATLAB on a desktop of 4 GHz (§6).
    """

    name: str
    stages: tuple[str, ...]
    paper: float
    unit: str


METHOD_STEPS = (
    MethodStep("reversibility score", ("reversibility",), 0.12, "shape"),
    MethodStep("QCRS", ("qcrs",), 1.99, "pair"),
    MethodStep("candidate trunks", ("trunks_full",), 10.36, "shape of a selected pair"),
    MethodStep("trunk pair selection (CRS)", ("crs",), 11.90, "selected pair"),
    MethodStep("boundary deformation", ("refine", "construct"), 131.4, "pair"),
)


def study(finished: StudiedRun, parameters: Parameters, say: Callable[[str], None]) -> Findings:
    """Seconds an item of every step, as its artifacts took when they were computed; nan where the run has none."""
    rows = {str(row["stage"]): row for row in finished.table("timings").to_pylist()}
    counts = _counts(finished)
    ours = []
    for step in METHOD_STEPS:
        stage_seconds = [_seconds(rows, stage, counts) for stage in step.stages]
        ours.append(sum(stage_seconds))
    faster = [step.paper / seconds for step, seconds in zip(METHOD_STEPS, ours, strict=True)]
    table = of_columns(
        "Time of each step of the method, beside the paper's.",
        [
            (column("step", pa.string(), "step of the method"), [step.name for step in METHOD_STEPS]),
            (column("item", pa.string(), "what the time is of"), [step.unit for step in METHOD_STEPS]),
            (
                column("paper", pa.float64(), "time of one item in the paper", "s"),
                [step.paper for step in METHOD_STEPS],
            ),
            (column("ours", pa.float64(), "mean time of one item in this run, on one core; nan = none", "s"), ours),
            (column("ratio", pa.float64(), "paper / ours", "1"), faster),
        ],
    )
    cells = [
        (step.name, step.unit, _words(step.paper), _words(seconds), f"{ratio:,.0f} ×" if math.isfinite(ratio) else "–")
        for step, seconds, ratio in zip(METHOD_STEPS, ours, faster, strict=True)
    ]
    figure = plots.bars(
        [step.name for step in METHOD_STEPS],
        {"paper": [step.paper for step in METHOD_STEPS], "this run": ours},
        "seconds an item",
    )
    return Findings(
        f"Time of {finished.mined.dataset}",
        "Mean time of each step, as the run's artifacts took when they were computed, reading and writing aside. The "
        "paper's machine was another one, and its boundary deformation is another method than the exact one.",
        table,
        [Sheet("Seconds an item", ("step", "of a", "paper", "this run", "ratio"), cells, 2)],
        {"timing": (figure, "Time of one item of each step")},
    )


def _counts(finished: StudiedRun) -> dict[str, int]:
    """How many items of the paper's kind are in a stage's work, where its work items are batches."""
    shapes = len(finished.mined.names)
    return {"reversibility": shapes, "qcrs": finished.quick.num_rows}


def _seconds(rows: dict[str, dict[str, float]], stage: str, counts: dict[str, int]) -> float:
    row = rows.get(stage)
    if row is None or row["stored_seconds"] is None:
        return math.nan
    items = counts.get(stage, row["cached"] + row["computed"])
    return float(row["stored_seconds"]) / items if items else math.nan


def _words(seconds: float) -> str:
    return f"{seconds:.3g} s" if seconds >= 0.1 else f"{1e3 * seconds:.3g} ms" if math.isfinite(seconds) else "–"

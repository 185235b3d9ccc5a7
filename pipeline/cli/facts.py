"""What a run, a plan and an explanation tell who wants JSON. Ours."""

from __future__ import annotations

from typing import Any

from pipeline.explain.causes import Causes
from pipeline.explain.forecast import Forecast
from pipeline.flow import RunOutcome
from pipeline.store.store import Store
from pipeline.tables.record import counts


def plan_facts(expected: Forecast) -> dict[str, Any]:
    """The work of each stage, as `--plan` shows it; numbers that only a run can know are null."""
    return {
        "stages": [
            {
                "stage": row.stage.name,
                "unit": row.stage.unit,
                "items": None if row.items is None else row.items,
                "cached": None if row.items is None else row.cached,
                "to_do": None if row.items is None else len(row.missing),
                "damaged": None if row.items is None else row.corrupt,
                "seconds": row.seconds,
                "known_after": row.stage.known_after if row.items is None else None,
            }
            for row in expected.stages
        ]
    }


def explanation_facts(expected: Forecast, store: Store) -> dict[str, Any]:
    """Why work items of each stage would run, as `--explain` shows it, with all causes."""
    causes = Causes(store, expected.pictures)
    stages = []
    for row in expected.stages:
        counted = causes.count(row.missing).most_common() if row.missing else []
        reasons = [{"items": count, "cause": cause} for cause, count in counted]
        stages.append({"stage": row.stage.name, "items": row.items, "to_do": len(row.missing), "causes": reasons})
    return {"stages": stages}


def outcome_facts(outcome: RunOutcome) -> dict[str, Any]:
    """The summary of a finished run."""
    return {
        "dataset": outcome.results.collection.name,
        "counts": counts(outcome.results),
        "stages": [
            {
                "stage": stage.stage,
                "items": stage.total,
                "cached": stage.cached,
                "computed": stage.computed,
                "failed": stage.failed + stage.blocked,
                "seconds": stage.seconds,
                "cpu_seconds": stage.cpu_seconds,
            }
            for stage in outcome.results.stages
        ],
        "seconds": outcome.seconds,
        "folder": outcome.folder,
        "report": outcome.report,
    }

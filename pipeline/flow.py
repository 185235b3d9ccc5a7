"""The pipeline itself: the list of stages, from a collection to tables and a report."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

import numpy as np

from pipeline.config.schema import Config
from pipeline.datasets.collection import Collection, collect
from pipeline.errors import StartError, StopError, StorageError
from pipeline.exit_codes import CLEAN, WITH_ERRORS
from pipeline.plan.plan import (
    Pair,
    Plan,
    WorkItem,
    make_plan,
    plan_construct,
    plan_crs,
    plan_fabrications,
    plan_full_trunks,
    plan_motions,
    plan_paint,
    plan_pairs,
    plan_paper,
    plan_refine,
    plan_search,
    plan_select,
    plan_shortlist,
)
from pipeline.report.assets import assets_digest
from pipeline.runtime.events import Listener, Note
from pipeline.runtime.execute import Run, open_run
from pipeline.runtime.quarantine import bring_scores, bring_shapes
from pipeline.store.filesystem.choose import open_files
from pipeline.store.location import Location
from pipeline.store.storage_errors import writing_to
from pipeline.tables.outputs import swept
from pipeline.tables.record import GALLERY, RECORD, REPORT, holds, outcome_digest, write_record
from pipeline.tables.results import Results, certified, least_deformed
from riot.types import FloatArray


@dataclass(frozen=True)
class Outcome:
    """How a run ended: the exit code, the folder of its tables, its report, and whether anything was written."""

    code: int
    folder: Path
    report: Path | None
    written: bool
    seconds: float
    results: Results


def run_folder(config: Config) -> Path:
    """Where the tables of a run go."""
    return config.outputs / config.dataset.name


def check_writable(place: Location, parameter: str) -> None:
    """Make a place and try to write in it.

    Raises `StartError` naming the place and the ``parameter`` that chooses another.
    """
    try:
        open_files(place).probe()
    except OSError as error:
        raise StartError(
            f"cannot write to {place}: {error.strerror or error}; make room or make it writable, or choose another "
            f"place with {parameter}=DIR"
        ) from error


def run_pipeline(config: Config, listen: Listener) -> Outcome:
    """Run everything that the store lacks and write the tables.

    A store that cannot be written will do for a run that finds everything in it.

    Raises `pipeline.datasets.collection.DatasetError` when there is no collection, `StartError` when a folder cannot
    be written or the cluster cannot be reached, `StopError` when the store or the outputs take no more, or the
    machine fails while the tables are written.
    """
    collection = collect(config.dataset)
    check_writable(run_folder(config), "outputs")
    unwritable = _unwritable(config.store)
    # What is not yet listed as needed must not be tidied away.
    with open_files(config.store).shared(), swept(run_folder(config)):
        try:
            return _run(config, collection, listen, unwritable)
        except OSError as error:  # a full disk, no memory to map a file: what is in the store stays there
            mend = "make room, or make it writable, and " if isinstance(error, StorageError) else ""
            raise StopError(f"{error}; {mend}give the same command again: it goes on from here") from error


def _unwritable(store: Location) -> StartError | None:
    """Why a store that is there cannot be written; raises `StartError` when there is none."""
    try:
        check_writable(store, "store")
    except StartError as error:
        with contextlib.suppress(OSError):
            if open_files(store).exists():
                return error
        raise
    return None


def _run(config: Config, collection: Collection, listen: Listener, unwritable: StartError | None) -> Outcome:
    started, clock = datetime.now(UTC), time.perf_counter()
    folder = run_folder(config)
    plan = make_plan(config, collection)
    with open_run(config.store, config.cluster, partial(_compile, listen), listen, unwritable) as run:
        results = _stages(plan, collection, run)
    digest = outcome_digest(results, assets_digest())
    code = WITH_ERRORS if results.errors or results.blocked else CLEAN
    nothing_new = all(stage.computed == 0 and stage.failed == 0 for stage in results.stages)
    if nothing_new and holds(folder, digest):
        return Outcome(code, folder, folder / REPORT, False, time.perf_counter() - clock, results)

    from pipeline.tables.write import write_tables  # here: a run that finds everything as it was writes nothing

    listen(Note("writing tables …"))
    with writing_to(folder):
        (folder / RECORD).unlink(missing_ok=True)  # until it is back, the folder holds no finished run
        files = write_tables(results, folder)
        times = {
            "started": started.isoformat(timespec="seconds"),
            "seconds": time.perf_counter() - clock,
            "workers": config.cluster.kind,
        }
        write_record(folder, results, digest, files, code, times)
        report = _report(folder, listen)
        if report is None:
            code = WITH_ERRORS
        else:
            gallery = sorted(path for path in (folder / GALLERY).rglob("*") if path.is_file())
            files = [*files, report, *gallery]
        times["seconds"] = time.perf_counter() - clock
        write_record(folder, results, digest, files, code, times)
    return Outcome(code, folder, report, True, time.perf_counter() - clock, results)


def _stages(plan: Plan, collection: Collection, run: Run) -> Results:
    plan, collection = bring_shapes(plan, collection, run)
    scored: dict[str, Sequence[WorkItem]] = {}
    if plan.pairs is None:
        plan, lost = bring_scores(plan, run)
        scored["qcrs"] = (*plan.qcrs.values(), *lost)
    else:
        plan = plan_search(plan, run.done)  # without the batches whose trunks failed
        scored["shards"] = plan.shards
        run.stage("shards", plan.shards)
        plan, lost = bring_scores(plan, run)
        scored["partners"] = (*plan.qcrs.values(), *lost)
        plan = plan_pairs(plan, run.done)
        assert plan.pairs is not None
        scored["pairs"] = (plan.pairs,)
        run.stage("pairs", [plan.pairs], here=True)
    select = plan_select(plan, run.done)
    run.stage("select", [select], here=True)
    pairs, scores = read_pairs(run, select)
    full = plan_full_trunks(plan, pairs)
    run.stage("trunks_full", list(full.values()))
    crs = plan_crs(plan, pairs, full)
    run.stage("crs", crs)
    refine = plan_refine(plan, crs)
    run.stage("refine", refine)
    refined = [item for item in refine if item.reference in run.done]
    shortlist = plan_shortlist(plan, refined)
    run.stage("shortlist", [shortlist], here=True)
    construct = plan_construct(plan, read_shortlist(run, shortlist, refined))
    run.stage("construct", construct)
    passed = certified(run.store, [item for item in construct if item.reference in run.done])
    beside: dict[str, Sequence[WorkItem]] = {}
    after: dict[str, Sequence[WorkItem]] = {}
    if plan.config.compare:
        beside["paper"] = plan_paper(plan, least_deformed(run.store, passed, plan.config.compare))
        run.stage("paper", beside["paper"])
    motion = plan_motions(plan, passed)
    run.stage("motion", motion)
    if paint := plan_paint(plan, motion):
        after["paint"] = paint
        run.stage("paint", paint)
    if plan.config.fabricate.top:
        best = least_deformed(run.store, passed, plan.config.fabricate.top)
        after["fabricate"] = plan_fabrications(plan, plan_motions(plan, best))
        run.stage("fabricate", after["fabricate"])
    return Results(
        plan=plan,
        collection=collection,
        store=run.store,
        done=frozenset(run.done),
        failed=dict(run.failed),
        blocked=len(run.blocked),
        pairs=tuple(pairs),
        qcrs=scores,
        work={
            "ingest": plan.ingest,
            "reversibility": plan.reversibility,
            "trunks": plan.trunks,
            **scored,
            "select": (select,),
            "trunks_full": tuple(full.values()),
            "crs": crs,
            "refine": refine,
            "shortlist": (shortlist,),
            "construct": construct,
            **beside,
            "motion": motion,
            **after,
        },
        stages=tuple(run.stages),
    )


def read_pairs(run: Run, select: WorkItem) -> tuple[Sequence[Pair], FloatArray]:
    """The pairs that a finished selection chose, best first, with their scores; none if it failed."""
    if select.reference not in run.done:
        return (), np.empty(0)
    chosen = run.store.get(*select.reference)
    return [(int(i), int(j)) for i, j in chosen.arrays["pairs"]], np.array(chosen.arrays["score"])


def read_shortlist(run: Run, shortlist: WorkItem, refined: Sequence[WorkItem]) -> list[WorkItem]:
    """The pairs that a finished shortlist names, the most promising first; none if it failed."""
    if shortlist.reference not in run.done:
        return []
    return [refined[place] for place in run.store.get(*shortlist.reference).arrays["places"]]


def _compile(listen: Listener) -> None:
    from riot.kernels.warm import warm_all

    warm_all(lambda text: listen(Note(text)))


def _report(folder: Path, listen: Listener) -> Path | None:
    from pipeline.report import write_report
    from pipeline.study.contents import write_contents

    listen(Note("writing the report …"))
    write: Callable[[Path], Path] = write_report
    try:
        with writing_to(folder):
            write_contents(folder)
            return write(folder)
    except StorageError:
        raise
    except Exception as error:  # the tables are whole: a run must not be lost by its picture book
        listen(Note(f"the report could not be written: {type(error).__name__}: {error}; the tables are complete"))
        return None

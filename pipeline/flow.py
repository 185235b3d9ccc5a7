"""The pipeline itself: the list of stages, from a collection to tables and a report."""

from __future__ import annotations

import contextlib
import importlib
import time
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from pipeline import report, study, tables  # modules of theirs are loaded when something is written
from pipeline.config.schema import Config
from pipeline.datasets.collection import DUPLICATE, Collection, collect
from pipeline.errors import StartError, StopError, StorageError
from pipeline.exit_codes import CLEAN, WITH_ERRORS
from pipeline.plan.progress import Progress
from pipeline.plan.work_item import WorkItem
from pipeline.report.assets import assets_digest
from pipeline.runtime.events import Listener, Note
from pipeline.runtime.execute import Run, open_run
from pipeline.runtime.profile import PROFILE, check_profile
from pipeline.runtime.quarantine import bring_blocks, bring_shapes
from pipeline.runtime.reuse import with_older_results
from pipeline.stages.all import STAGES, begin_run
from pipeline.store.filesystem.choose import open_files
from pipeline.store.location import Location
from pipeline.store.storage_errors import writing_to
from pipeline.store.store import Store
from pipeline.tables.outputs import run_folder, swept
from pipeline.tables.record import CHECK, GALLERY, RECORD, REPORT, is_up_to_date, outcome_digest, write_record
from pipeline.tables.results import Results
from riot.errors import MissingExtraError, needs_extra


@dataclass(frozen=True)
class RunOutcome:
    """The outcome of a run: exit code, folder of tables, report, and whether anything was written."""

    code: int
    folder: Path
    report: Path | None
    written: bool
    seconds: float
    results: Results


def check_writable(location: Location, parameter: str) -> None:
    """Make a folder or bucket, and try to write to it.

    Raises `StartError` with the location and the ``parameter`` that chooses another.
    """
    try:
        open_files(location).probe()
    except OSError as error:
        raise StartError(
            f"cannot write to {location}: {error.strerror or error}; free space or make it writable, or choose another "
            f"with {parameter}=DIR"
        ) from error


def run_pipeline(config: Config, listen: Listener) -> RunOutcome:
    """Run everything that the store lacks and write the tables.

    A store that cannot be written will do for a run that finds everything in it.

    Raises `pipeline.datasets.collection.DatasetError` when there is no collection, `StartError` when a folder cannot
    be written or the cluster cannot be reached, `StopError` when the store or the outputs take no more, or the
    machine fails while the tables are written.
    """
    collection = collect(config.dataset)
    check_writable(run_folder(config), "outputs")
    _check_extras(config)
    if config.profile:
        check_profile(config.cluster)
    if config.signing is not None:
        config.signing.sign("")  # raises where there is no key
    unwritable = _unwritable(config.store)
    # `pipeline.cache gc` must not delete artifacts that no finished run lists yet.
    with open_files(config.store).shared(), swept(run_folder(config)):
        try:
            return _run(config, collection, listen, unwritable)
        except OSError as error:  # such as a full disk; what is in the store stays
            mend = "free space, or make it writable, and " if isinstance(error, StorageError) else ""
            raise StopError(f"{error}; {mend}give the same command again: it goes on from here") from error


def _check_extras(config: Config) -> None:
    """Raise `StartError` if a stage needs a package that is not installed: else each of its work items would fail."""
    if config.fabricate.top:
        try:
            with needs_extra("print"):
                importlib.import_module("manifold3d")
        except MissingExtraError as error:
            raise StartError(f"fabricate.top={config.fabricate.top}: {error}") from error


def _unwritable(store: Location) -> StartError | None:
    """The error of an existing store that cannot be written; raises `StartError` if there is no store."""
    try:
        check_writable(store, "store")
    except StartError as error:
        with contextlib.suppress(OSError):
            if open_files(store).exists():
                return error
        raise
    return None


def _run(config: Config, collection: Collection, listen: Listener, unwritable: StartError | None) -> RunOutcome:
    started, clock = datetime.now(UTC), time.perf_counter()
    folder = run_folder(config)
    stages = [stage for stage in STAGES if stage.wanted(config)]
    profile = folder / PROFILE if config.profile else None
    with open_run(Store(config.store, config.signing), config.cluster, stages, listen, unwritable, profile) as run:
        progress = run_stages(begin_run(config, collection, run.store), run)
    if profile is not None:
        written = profile.is_file() and any(stage.worker_seconds for stage in run.stages)
        listen(Note(f"profile: {profile}" if written else "nothing was computed, and so there is no profile"))
    results = Results(progress, run.store, dict(run.failed), len(run.blocked), tuple(run.stages))
    digest = outcome_digest(results, assets_digest())
    # Two files with the same bytes are a remark: nothing is lost.
    lost = [row for row in results.errors if row["reason"] != DUPLICATE]
    code = WITH_ERRORS if lost or results.blocked else CLEAN
    nothing_new = all(stage.computed == 0 and stage.failed == 0 for stage in results.stages)
    if nothing_new and is_up_to_date(folder, digest):
        return RunOutcome(code, folder, folder / REPORT, False, time.perf_counter() - clock, results)

    listen(Note("writing tables …"))
    with writing_to(folder):
        (folder / RECORD).unlink(missing_ok=True)  # until it is back, the folder holds no finished run
        files = tables.write.write_tables(results, folder)
        times = {
            "started": started.isoformat(timespec="seconds"),
            "seconds": time.perf_counter() - clock,
            "workers": config.cluster.kind,
        }
        write_record(folder, results, digest, files, code, times)
        page = _report(results, folder, listen)
        if page is None:
            code = WITH_ERRORS
        else:
            gallery = sorted(path for path in (folder / GALLERY).rglob("*") if path.is_file())
            files = [*files, page, folder / CHECK, *gallery]
        times["seconds"] = time.perf_counter() - clock
        write_record(folder, results, digest, files, code, times)
    return RunOutcome(code, folder, page, True, time.perf_counter() - clock, results)


def run_stages(progress: Progress, run: Run) -> Progress:
    """Bring the work of every stage that the configuration asks for into the store, in order."""
    progress = bring_shapes(progress, run)
    for stage in STAGES:
        if stage.name in progress.work or not stage.wanted(progress.config):
            continue
        lost: Sequence[WorkItem] = ()
        if stage.sub_blocks is not None:
            items, lost = bring_blocks(progress, stage, run)
        else:
            items = list(stage.items(progress))
            if not stage.is_due(items):
                continue  # no line of output for a stage without work
            run.stage(stage, with_older_results(run.store, items))
        progress = progress.with_work(stage.name, items, frozenset(run.done), lost)
    return progress


def _report(results: Results, folder: Path, listen: Listener) -> Path | None:
    listen(Note("writing the report …"))
    try:
        with writing_to(folder):
            study.contents.write_contents(folder)
            report.check.write_check(results, folder)
            return report.write.write_report(folder)
    except StorageError:
        raise
    except Exception as error:  # the tables are whole: the report must not fail the run
        listen(Note(f"the report could not be written: {type(error).__name__}: {error}; the tables are complete"))
        return None

"""Entry point: ``python -m pipeline.run [+dataset=NAME] [name=value …] [--plan | --explain] [-m]``.

``--help`` lists every parameter. Exit codes: 0 clean, 3 finished with errors, 2 could not start, 1 had to stop (a full
disk, a failing machine …), 130 interrupted; of a sweep the greatest of its jobs'. After 1 and 130 the same command goes
on from there.
"""

from __future__ import annotations

import dataclasses
import logging
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import hydra
from hydra.core.hydra_config import HydraConfig
from omegaconf import DictConfig
from rich.console import Console

import pipeline.runtime.threads
from pipeline import cli, explain, tables  # their modules are loaded at first use: a start should be quick
from pipeline.config.command_line import (
    HYDRA_BASE,
    check_command,
    complete,
    is_multirun,
    is_plain,
    make_typed,
    sweep_point,
    sweep_values,
)
from pipeline.config.conf_files import CONF
from pipeline.config.help import help_text, wants_help
from pipeline.config.schema import Config
from pipeline.datasets.collection import DatasetError
from pipeline.errors import ConfigError, StartError
from pipeline.exit_codes import BAD_START, CLEAN, FAILED, INTERRUPTED
from pipeline.store.store import Store
from riot.errors import RiotError

PIPED_WIDTH = 140


@dataclass(frozen=True)
class JobEnd:
    """The outcome of a job: exit code, and the folder of its tables if it finished, else the message."""

    code: int
    folder: Path | None = None
    message: str = ""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code of the run, of a sweep the worst one."""
    console, complaints = _console(), Console(stderr=True, soft_wrap=True, emoji=False)
    arguments = sys.argv[1:] if arguments is None else arguments
    if wants_help(arguments):
        print(help_text())
        return CLEAN
    options = complete(arguments)
    config: Config | None = None
    try:
        if is_plain(options):
            config = check_command(options)
            if (config.plan or config.explain) and not is_multirun(options):
                return _show(config, console)
            if not (config.plan or config.explain):
                pipeline.flow.check_writable(config.outputs, "outputs")  # Hydra writes its log there
        ended = _with_hydra(options, console, complaints)
        if config is not None and is_multirun(options) and not (config.plan or config.explain):
            _tell_sweep(options, config.outputs, ended, console)
    except KeyboardInterrupt:
        return _interrupted(complaints)
    except (RiotError, OSError) as error:
        return _refused(error, complaints).code
    return max((job.code for _, job in ended), default=CLEAN)


def _with_hydra(arguments: Sequence[str], console: Console, complaints: Console) -> list[tuple[Sequence[str], JobEnd]]:
    """Have Hydra compose and run every job; returns the overrides of each and how it ended."""
    ended: list[tuple[Sequence[str], JobEnd]] = []
    begun = False

    @hydra.main(version_base=HYDRA_BASE, config_path=str(CONF), config_name="config")
    def job(composed: DictConfig) -> None:
        nonlocal begun
        begun = True
        chosen = list(HydraConfig.get().overrides.task)
        if is_multirun(arguments):
            ended.append((chosen, _job(composed, sweep_point(arguments, chosen), console, complaints)))
        else:
            ended.append((chosen, run_job(make_typed(composed), console, complaints)))

    program, sys.argv = sys.argv, [sys.argv[0], *arguments]
    try:
        job()
    except SystemExit as stop:  # Hydra printed the reason
        failed = FAILED if begun else BAD_START
        return [*ended, ((), JobEnd(failed if stop.code else CLEAN))]
    finally:
        sys.argv = program
    return ended


def _job(composed: DictConfig, point: str, console: Console, complaints: Console) -> JobEnd:
    """Run a job of a sweep; the other jobs run whatever ends this one, except an interrupt."""
    try:
        config = make_typed(composed)
        if point:  # else every point of a sweep would replace the tables of the one before
            config = dataclasses.replace(config, outputs=config.outputs / point)
        return run_job(config, console, complaints)
    except RiotError as error:
        return _refused(error, complaints)
    except Exception as error:
        logging.getLogger(__name__).exception("a job of the sweep broke off")  # into Hydra's folder, with all of it
        message = f"{type(error).__name__}: {error}"
        complaints.print(f"The job broke off: {message}", style="red", highlight=False, markup=False)
        return JobEnd(FAILED, message=message)


def run_job(config: Config, console: Console, complaints: Console) -> JobEnd:
    """Run one configuration, or show its plan; whatever ends it is printed and told by the exit code."""
    if config.plan or config.explain:
        return JobEnd(_show(config, console))
    try:
        with cli.progress.show_progress(console) as listen:
            outcome = pipeline.flow.run_pipeline(config, listen)
    except RiotError as error:
        return _refused(error, complaints)
    cli.summary.show_outcome(outcome, console)
    return JobEnd(outcome.code, outcome.folder)


def _tell_sweep(
    arguments: Sequence[str], outputs: Path, ended: Sequence[tuple[Sequence[str], JobEnd]], console: Console
) -> None:
    jobs = [
        tables.sweep.SweepJob(sweep_values(arguments, chosen), job.code, job.folder, job.message)
        for chosen, job in ended
        if chosen
    ]
    if not (jobs and jobs[0].values):
        return
    folder = tables.sweep.write_sweep(outputs, jobs)
    console.print(f"Sweep of {len(jobs)} jobs: {folder}", highlight=False, soft_wrap=True, markup=False)


def _show(config: Config, console: Console) -> int:
    store = Store(config.store)
    expected = explain.forecast.forecast(config, store)
    if config.explain:
        explain.show.show_explanation(expected, store, console)
    else:
        explain.show.show_plan(expected, config, console)
    return CLEAN


def _refused(error: Exception, complaints: Console) -> JobEnd:
    """Print the error; the exit code says whether it kept the run from starting or stopped it."""
    started = not isinstance(error, ConfigError | DatasetError | StartError)
    verb = "Stopped" if started else "Cannot start"
    complaints.print(f"{verb}: {error}", style="red", highlight=False, markup=False)
    return JobEnd(FAILED if started else BAD_START, message=str(error))


def _interrupted(complaints: Console) -> int:
    complaints.print("Interrupted. What is done is kept: the same command goes on from here.", highlight=False)
    return INTERRUPTED


def _console() -> Console:
    console = Console(highlight=False, emoji=False)
    return console if console.is_terminal else Console(highlight=False, emoji=False, width=PIPED_WIDTH)


if __name__ == "__main__":
    sys.exit(main())

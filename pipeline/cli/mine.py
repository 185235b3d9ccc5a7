"""The command `riot mine [+dataset=NAME] [name=value …] [--plan | --explain] [-m]`, as ``python -m pipeline.run``.

After the exit codes 1 and 130 the same command goes on from where it was. Ours.
"""

from __future__ import annotations

import argparse
import dataclasses
import logging
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import hydra
import rich.console
from hydra.core.hydra_config import HydraConfig
from omegaconf import DictConfig

import pipeline.runtime.threads
from pipeline import cli, explain, tables  # their modules are loaded at first use: a start should be quick
from pipeline.config.command_line import (
    HYDRA_BASE,
    check_command,
    check_words,
    complete,
    is_multirun,
    is_plain,
    make_typed,
    sweep_point,
    sweep_values,
)
from pipeline.config.conf_files import CONF
from pipeline.config.help import add_assignments, run_names, run_sections
from pipeline.config.schema import Config
from pipeline.datasets.collection import DatasetError
from pipeline.errors import ConfigError, StartError
from pipeline.exit_codes import BAD_START, CLEAN, FAILED, MEANINGS
from pipeline.store.store import Store
from riot.cli.output import Output
from riot.cli.parser import PIPE_CLOSED, Parser
from riot.errors import RiotError

ABOUT = (
    "Mine a collection of silhouettes for pairs that turn inside out into each other. Tables and a report go to "
    "outputs/DATASET/. Without +dataset=NAME the embedded sample is mined. The same command resumes a run that was "
    "stopped, and computes only what is not in the store."
)

PIPED_WIDTH = 140
"""Columns of a table that goes to a file or a pipe (ours)."""

LEAST_WIDTH = 60
"""Columns of a table on a narrow terminal, which breaks its lines: else cells would be empty (ours)."""

HYDRA_FLAGS = (("--resolve",), ("--run", "-r"), ("--shell-completion", "-sc"))
HYDRA_OPTIONS = (
    ("--package", "-p"),
    ("--config-path", "-cp"),
    ("--config-name", "-cn"),
    ("--config-dir", "-cd"),
    ("--experimental-rerun",),
    ("--info", "-i"),
)
"""What else Hydra takes; ``--hydra-help`` describes it."""


@dataclass(frozen=True)
class JobEnd:
    """The outcome of a job: exit code, and the folder of its tables if it finished, else the message."""

    code: int
    folder: Path | None = None
    message: str = ""
    facts: dict[str, Any] | None = None
    """What it tells who wants JSON."""


def add_options(parser: Parser) -> None:
    """See `riot.cli.command.CommandModule`."""
    add_assignments(parser, run_names)
    parser.add_argument("--plan", action="store_true", help="show what would run, and stop")
    parser.add_argument("--explain", action="store_true", help="show why each work item would run, and stop")
    parser.add_argument("--profile", action="store_true", help="write profile.html, Dask's report of where time goes")
    parser.add_argument(
        "-m",
        "--multirun",
        action="store_true",
        help="sweep: run each combination of values such as trunks.tau_s=0.07,0.1",
    )
    parser.add_argument("-c", "--cfg", choices=("job", "hydra", "all"), help="print the configuration, and stop")
    parser.add_argument("--hydra-help", action="store_true", help="print the flags of Hydra, which reads name=value")
    for names in HYDRA_FLAGS:
        parser.add_argument(*names, action="store_true", help=argparse.SUPPRESS)
    for names in HYDRA_OPTIONS:
        parser.add_argument(*names, help=argparse.SUPPRESS)
    parser.description = ABOUT
    parser.sections.append(run_sections)
    parser.exit_codes = MEANINGS


def run(chosen: argparse.Namespace, output: Output) -> int:
    """See `riot.cli.command.CommandModule`; the exit code of a sweep is the greatest of its jobs'."""
    options = complete(chosen.arguments)
    config: Config | None = None
    try:
        if is_plain(options):
            check_words(chosen.assignments)
            config = check_command(options)
            if (config.plan or config.explain) and not is_multirun(options):
                output.document(_show(config, output))
                return CLEAN
            if not (config.plan or config.explain):
                pipeline.flow.check_writable(config.outputs, "outputs")  # Hydra writes its log there
        ended = _with_hydra(options, output)
        if config is not None and is_multirun(options) and not (config.plan or config.explain):
            _tell_sweep(options, config.outputs, ended, output)
        _document(ended, output, sweep=is_multirun(options))
    except BrokenPipeError:
        raise
    except (RiotError, OSError) as error:
        return _refused(error, output).code
    return max((job.code for _, job in ended), default=CLEAN)


def _with_hydra(arguments: Sequence[str], output: Output) -> list[tuple[Sequence[str], JobEnd]]:
    """Have Hydra compose and run every job; returns the overrides of each and how it ended."""
    ended: list[tuple[Sequence[str], JobEnd]] = []
    begun = False

    @hydra.main(version_base=HYDRA_BASE, config_path=str(CONF), config_name="config")
    def job(composed: DictConfig) -> None:
        nonlocal begun
        begun = True
        chosen = list(HydraConfig.get().overrides.task)
        if is_multirun(arguments):
            ended.append((chosen, _job(composed, sweep_point(arguments, chosen), output)))
        else:
            ended.append((chosen, run_job(make_typed(composed), output)))

    program, sys.argv = sys.argv, [sys.argv[0], *arguments]
    try:
        job()
    except SystemExit as stop:  # Hydra printed the reason
        failed = FAILED if begun else BAD_START
        return [*ended, ((), JobEnd(failed if stop.code else CLEAN))]
    finally:
        sys.argv = program
    return ended


def _job(composed: DictConfig, point: str, output: Output) -> JobEnd:
    """Run a job of a sweep; the other jobs run whatever ends this one, except an interrupt."""
    try:
        config = make_typed(composed)
        if point:  # else every point of a sweep would replace the tables of the one before
            config = dataclasses.replace(config, outputs=config.outputs / point)
        return run_job(config, output)
    except RiotError as error:
        return _refused(error, output)
    except Exception as error:
        logging.getLogger(__name__).exception("a job of the sweep broke off")  # into Hydra's folder, with all of it
        message = f"{type(error).__name__}: {error}"
        _complain(f"The job broke off: {message}", output)
        return JobEnd(FAILED, message=message)


def run_job(config: Config, output: Output) -> JobEnd:
    """Run one configuration, or show its plan; whatever ends it is printed and told by the exit code."""
    if config.plan or config.explain:
        return JobEnd(CLEAN, facts=_show(config, output))
    console = _console(output)
    try:
        with cli.progress.show_progress(console) as listen:
            outcome = pipeline.flow.run_pipeline(config, listen)
        cli.summary.show_outcome(outcome, console, verbose=output.verbose)
    except BrokenPipeError:
        return JobEnd(PIPE_CLOSED)
    except RiotError as error:
        return JobEnd(PIPE_CLOSED) if isinstance(error.__cause__, BrokenPipeError) else _refused(error, output)
    return JobEnd(outcome.code, outcome.folder, facts=cli.facts.outcome_facts(outcome) if output.json else None)


def _tell_sweep(
    arguments: Sequence[str], outputs: Path, ended: Sequence[tuple[Sequence[str], JobEnd]], output: Output
) -> None:
    jobs = [
        tables.sweep.SweepJob(sweep_values(arguments, chosen), job.code, job.folder, job.message)
        for chosen, job in ended
        if chosen
    ]
    if not (jobs and jobs[0].values):
        return
    folder = tables.sweep.write_sweep(outputs, jobs)
    output.show(f"Sweep of {len(jobs)} jobs: {folder}")


def _show(config: Config, output: Output) -> dict[str, Any]:
    store, console = Store(config.store, config.signing), _console(output)
    expected = explain.forecast.forecast(config, store)
    if output.json:
        facts = cli.facts.explanation_facts(expected, store) if config.explain else cli.facts.plan_facts(expected)
        return {"dataset": config.dataset.name, **facts}
    if config.explain:
        explain.show.show_explanation(expected, store, console)
    else:
        explain.show.show_plan(expected, config, console)
    return {}


def _document(ended: Sequence[tuple[Sequence[str], JobEnd]], output: Output, *, sweep: bool) -> None:
    """Print the facts of the job, or of every job of a sweep, if JSON is wanted."""
    jobs = [
        {"arguments": list(chosen), "exit_code": job.code, "message": job.message or None, **(job.facts or {})}
        for chosen, job in ended
        if chosen or job.facts
    ]
    if sweep:
        output.document({"jobs": jobs})
    elif jobs:
        output.document(jobs[0])


def _console(output: Output) -> rich.console.Console:
    """Where the progress and the summary of a run go: away from the JSON document, and nowhere for who wants quiet."""
    # Names of files stand as they are: to rich, brackets are colours.
    console = rich.console.Console(stderr=output.json, quiet=output.quiet, highlight=False, emoji=False, markup=False)
    console.width = max(console.width, LEAST_WIDTH) if console.is_terminal else PIPED_WIDTH
    return console


def _refused(error: Exception, output: Output) -> JobEnd:
    """Print the error; the exit code says whether it kept the run from starting or stopped it."""
    started = not isinstance(error, ConfigError | DatasetError | StartError)
    _complain(f"{'Stopped' if started else 'Cannot start'}: {error}", output)
    return JobEnd(FAILED if started else BAD_START, message=str(error))


def _complain(text: str, output: Output) -> None:
    complaints = rich.console.Console(stderr=True, soft_wrap=True, emoji=False)
    if output.verbose:
        complaints.print_exception()
    complaints.print(output.worded(text), style="red", highlight=False, markup=False)

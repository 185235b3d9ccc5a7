"""Entry point: ``python -m pipeline.run [+dataset=NAME] [name=value …] [--plan | --explain] [-m]``.

Exit codes: 0 clean, 3 finished with errors, 2 could not start, 130 interrupted.
"""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Sequence

import hydra
from hydra.core.hydra_config import HydraConfig
from omegaconf import DictConfig
from rich.console import Console

import pipeline.threads  # noqa: F401  (before anything that loads a numeric library)
from pipeline.command import CONF, HYDRA_BASE, check_command, complete, is_multirun, is_plain, make_typed, sweep_point
from pipeline.config import Config
from pipeline.errors import PipelineError
from pipeline.explain import forecast, show_explanation, show_plan
from pipeline.flow import BAD_START, CLEAN, check_writable, run_pipeline
from pipeline.progress import show_progress
from pipeline.store import Store
from pipeline.summary import show_outcome
from riot.errors import RiotError

INTERRUPTED = 130
PIPED_WIDTH = 140


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code of the run, of a sweep the worst one."""
    console, complaints = _console(), Console(stderr=True, soft_wrap=True)
    given = complete(sys.argv[1:] if arguments is None else arguments)
    try:
        if is_plain(given):
            config = check_command(given)
            if (config.plan or config.explain) and not is_multirun(given):
                return _show(config, console)
            if not (config.plan or config.explain):
                check_writable(config.outputs, "outputs")  # Hydra writes its log there
        codes = _with_hydra(given, console, complaints)
    except KeyboardInterrupt:
        return _interrupted(complaints)
    except RiotError as error:
        return _refused(error, complaints)
    return max(codes, default=CLEAN)


def _with_hydra(arguments: Sequence[str], console: Console, complaints: Console) -> list[int]:
    codes: list[int] = []

    @hydra.main(version_base=HYDRA_BASE, config_path=str(CONF), config_name="config")
    def job(composed: DictConfig) -> None:
        chosen = HydraConfig.get().overrides.task if is_multirun(arguments) else []
        codes.append(_run(composed, sweep_point(arguments, chosen), console, complaints))

    program, sys.argv = sys.argv, [sys.argv[0], *arguments]
    try:
        job()
    except SystemExit as stop:  # Hydra has said why
        return [*codes, BAD_START if stop.code else CLEAN]
    finally:
        sys.argv = program
    return codes


def _run(composed: DictConfig, point: str, console: Console, complaints: Console) -> int:
    try:
        config = make_typed(composed)
        if point:  # else every point of a sweep would replace the tables of the one before
            config = dataclasses.replace(config, outputs=config.outputs / point)
        if config.plan or config.explain:
            return _show(config, console)
        with show_progress(console) as listen:
            outcome = run_pipeline(config, listen)
        show_outcome(outcome, console)
        return outcome.code
    except KeyboardInterrupt:
        return _interrupted(complaints)
    except RiotError as error:
        return _refused(error, complaints)


def _show(config: Config, console: Console) -> int:
    store = Store(config.store)
    found = forecast(config, store)
    if config.explain:
        show_explanation(found, store, console)
    else:
        show_plan(found, config, console)
    return CLEAN


def _refused(error: RiotError, complaints: Console) -> int:
    kind = "Cannot start" if isinstance(error, PipelineError | OSError) else type(error).__name__
    complaints.print(f"{kind}: {error}", style="red", highlight=False, markup=False)
    return BAD_START


def _interrupted(complaints: Console) -> int:
    complaints.print("Interrupted. What is done is kept: the same command goes on from here.", highlight=False)
    return INTERRUPTED


def _console() -> Console:
    console = Console(highlight=False)
    return console if console.is_terminal else Console(highlight=False, width=PIPED_WIDTH)


if __name__ == "__main__":
    sys.exit(main())

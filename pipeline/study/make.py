"""Make one study of a finished run: arguments in, files of its findings out. Ours."""

from __future__ import annotations

import dataclasses
import difflib
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Protocol

from pipeline.config.build import build, unknown_name
from pipeline.config.command_line import check_command, check_words, complete
from pipeline.config.conf_files import allowed_names, group_choices
from pipeline.errors import ConfigError, StartError
from pipeline.study.contents import write_contents
from pipeline.study.findings import Findings, write_findings
from pipeline.study.finished import StudiedRun
from pipeline.tables.outputs import run_folder
from pipeline.tables.record import RECORD, STUDY
from riot.errors import needs_extra
from riot.kernels.warm import compile_used
from riot.parameters import ParameterGroup

with needs_extra("mine"):
    from omegaconf import OmegaConf

Say = Callable[[str], None]


class Study(Protocol):
    """A module that is a study: ``Parameters`` is a group of parameters with defaults."""

    __name__: str

    @property
    def Parameters(self) -> type[ParameterGroup]: ...

    def study(self, finished: StudiedRun, parameters: Any, say: Say) -> Findings: ...


def make_study(name: str, study: Study, arguments: Sequence[str], say: Say) -> tuple[Findings, Path]:
    """Make a study of the run that ``arguments`` name; returns its findings and the path of their page.

    Raises `RiotError` if the arguments are wrong or the run cannot be read.
    """
    study_arguments, run_arguments = split(arguments, study.Parameters)
    check_words(run_arguments)
    _check_names(run_arguments, [field.name for field in dataclasses.fields(study.Parameters)])
    parameters: Any = build(study.Parameters, study_arguments)
    config = check_command(complete(run_arguments))
    folder = run_folder(config)
    if not (folder / RECORD).exists():
        raise StartError(
            f"{folder}: no finished run here; `{' '.join(('python -m pipeline.run', *run_arguments))}` makes it, or "
            "name another run by +dataset=NAME, outputs=DIR"
        )
    moved = any(argument.startswith("store=") for argument in run_arguments)
    finished = StudiedRun.open(folder, config.store if moved else None)
    compile_used(say, study.__name__)
    findings = study.study(finished, parameters, say)
    page = write_findings(findings, folder / STUDY / name)
    write_contents(folder)
    return findings, page


def _check_names(run_arguments: Sequence[str], own: Sequence[str]) -> None:
    """Raise `ConfigError` for a name that is no parameter, and is like one of the study's ``own``."""
    of_run = {*allowed_names(), *group_choices()}
    for name in (argument.partition("=")[0].lstrip("+~") for argument in run_arguments):
        if name not in of_run and difflib.get_close_matches(name, own):
            raise ConfigError(unknown_name(name, list(own)))


def split(arguments: Sequence[str], parameters: type[ParameterGroup]) -> tuple[dict[str, Any], list[str]]:
    """The values of a study's own parameters, and the arguments that are the run's; raises `ConfigError`.

    >>> from pipeline.study.consistency import Parameters
    >>> split(["pairs=20", "outputs=here"], Parameters)
    ({'pairs': 20}, ['outputs=here'])
    """
    names = {field.name for field in dataclasses.fields(parameters)}
    study_arguments = [argument for argument in arguments if argument.partition("=")[0] in names]
    if any("=" not in argument for argument in study_arguments):
        raise ConfigError(f"{study_arguments[0]}: give a value, {study_arguments[0]}=…")
    values = OmegaConf.to_container(OmegaConf.from_dotlist(study_arguments))
    assert isinstance(values, dict)
    return {str(name): value for name, value in values.items()}, [
        item for item in arguments if item not in study_arguments
    ]

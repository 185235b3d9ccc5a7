"""Entry point: ``python -m pipeline.study NAME [+dataset=…] [name=value …]``, over a finished run of the same data.

Names are those of the run (`dataset`, `outputs`, `store` …) and the study's own parameters. Findings go to
``<outputs>/<dataset>/study/NAME/``. Exit codes: 0 done, 2 could not be done.
"""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Sequence
from typing import Any

from omegaconf import OmegaConf
from rich.console import Console

import pipeline.runtime.threads  # noqa: F401  (before anything that loads a numeric library)
from pipeline.config.command_line import check_command, complete
from pipeline.config.schema import build
from pipeline.errors import ConfigError
from pipeline.exit_codes import BAD_START, CLEAN
from pipeline.flow import run_folder
from pipeline.study.contents import write_contents
from pipeline.study.findings import write_findings
from pipeline.study.finished import Finished
from pipeline.study.registry import STUDIES
from pipeline.tables.record import STUDY
from riot.errors import RiotError
from riot.kernels.warm import warm_all


def main(arguments: Sequence[str] | None = None) -> int:
    """Make one study; returns the exit code."""
    console, complaints = (
        Console(highlight=False, soft_wrap=True),
        Console(stderr=True, soft_wrap=True, highlight=False),
    )
    given = list(sys.argv[1:] if arguments is None else arguments)
    if not given or given[0] not in STUDIES:
        asked = f"{given[0]}: no such study" if given else "name a study"
        known = "\n".join(f"  {name:14} {study.meaning}" for name, study in STUDIES.items())
        complaints.print(f"{asked}; there are\n{known}\n{__doc__}", markup=False)
        return BAD_START
    name, study = given[0], STUDIES[given[0]]

    def say(text: str) -> None:
        complaints.print(text, markup=False)

    try:
        own, others = split(given[1:], study.parameters)
        parameters: Any = build(study.parameters, own)
        config = check_command(complete(others))
        warm_all(say)
        folder = run_folder(config)
        found = study.run(Finished.open(folder), parameters, say)
        page = write_findings(found, folder / STUDY / name)
        write_contents(folder)
    except RiotError as error:
        complaints.print(str(error), style="red", markup=False)
        return BAD_START
    console.print(f"{found.title}: {found.lead}", markup=False)
    console.print(f"Report: {page}", markup=False)
    return CLEAN


def split(arguments: Sequence[str], parameters: type) -> tuple[dict[str, Any], list[str]]:
    """The values of a study's own parameters, and the arguments that are the run's; raises `ConfigError`."""
    names = {field.name for field in dataclasses.fields(parameters)}
    own = [one for one in arguments if one.partition("=")[0] in names]
    if any("=" not in one for one in own):
        raise ConfigError(f"{own[0]}: give a value, {own[0]}=…")
    values = OmegaConf.to_container(OmegaConf.from_dotlist(own))
    assert isinstance(values, dict)
    return {str(name): value for name, value in values.items()}, [one for one in arguments if one not in own]


if __name__ == "__main__":
    sys.exit(main())

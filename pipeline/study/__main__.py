"""Entry point: ``python -m pipeline.study NAME [+dataset=…] [name=value …]``, over a finished run of the same data.

Names are those of the run (`dataset`, `outputs`, `store` …) and the study's own parameters. Findings go to
``<outputs>/<dataset>/study/NAME/``. Exit codes: 0 done, 2 could not be done.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

from rich.console import Console

import pipeline.runtime.threads  # noqa: F401  (before anything that loads a numeric library)
from pipeline import study
from pipeline.exit_codes import BAD_START, CLEAN
from pipeline.study.registry import STUDIES
from riot.errors import RiotError


def main(arguments: Sequence[str] | None = None) -> int:
    """Make one study; returns the exit code."""
    console = Console(highlight=False, soft_wrap=True)
    complaints = Console(stderr=True, soft_wrap=True, highlight=False)
    options = list(sys.argv[1:] if arguments is None else arguments)
    known = "\n".join(f"  {name:14} {meaning}" for name, meaning in STUDIES.items())
    if options[:1] in (["--help"], ["-h"]):
        console.print(f"{__doc__}\n{known}", markup=False)
        return CLEAN
    if not options or options[0] not in STUDIES:
        mistake = f"{options[0]}: no such study" if options else "name a study"
        complaints.print(f"{mistake}; there are\n{known}\n{__doc__}", markup=False)
        return BAD_START
    name = options[0]

    def say(text: str) -> None:
        complaints.print(text, markup=False)

    try:
        findings, page = study.make.make_study(name, getattr(study, name), options[1:], say)
    except RiotError as error:
        complaints.print(str(error), style="red", markup=False)
        return BAD_START
    console.print(f"{findings.title}: {findings.lead}", markup=False)
    console.print(f"Report: {page}", markup=False)
    return CLEAN


if __name__ == "__main__":
    sys.exit(main())

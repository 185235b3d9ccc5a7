"""The command `riot study NAME [+dataset=…] [name=value …]`, over a finished run of the same data. Ours.

Names are those of the run (``dataset``, ``outputs``, ``store`` …) and the study's own parameters.
"""

from __future__ import annotations

import argparse
import textwrap
from dataclasses import dataclass

from pipeline import study
from pipeline.config.help import add_assignments, group_section, run_names
from pipeline.exit_codes import CLEAN
from pipeline.study.registry import STUDIES
from riot.cli.output import Output
from riot.cli.parser import Parser, columns, listing


@dataclass(frozen=True)
class StudyCommand:
    """The study ``name`` as a command."""

    name: str

    def add_options(self, parser: Parser) -> None:
        """See `riot.cli.command.CommandModule`."""
        parameters = getattr(study, self.name).Parameters
        add_assignments(parser, lambda: {**dict.fromkeys(parameters.__dataclass_fields__, ()), **run_names()})
        parser.sections.append(lambda: group_section("parameters of the study", parameters))
        parser.sections.append(_run_section)

    def run(self, chosen: argparse.Namespace, output: Output) -> int:
        """See `riot.cli.command.CommandModule`."""
        findings, page = study.make.make_study(self.name, getattr(study, self.name), chosen.assignments, output.note)
        facts = {"study": self.name, "title": findings.title, "lead": findings.lead, "page": page}
        output.facts(facts, f"{findings.title}: {findings.lead}", f"Report: {page}")
        return CLEAN


class StudyList:
    """The command that lists all studies."""

    def add_options(self, parser: Parser) -> None:
        """See `riot.cli.command.CommandModule`."""

    def run(self, chosen: argparse.Namespace, output: Output) -> int:
        """See `riot.cli.command.CommandModule`."""
        studies = [{"name": name, "asks": meaning} for name, meaning in STUDIES.items()]
        output.facts({"studies": studies}, listing("studies", STUDIES).rstrip())
        return CLEAN


LIST = StudyList()


def _run_section() -> str:
    text = (
        "parameters of the run say which run is studied: give those that the run was given, such as +dataset=mpeg7, "
        "dataset.root=DIR, outputs=DIR; `python -m pipeline.run --help` lists them."
    )
    return f"{textwrap.fill(text, columns())}\n"

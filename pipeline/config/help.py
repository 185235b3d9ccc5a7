"""What `python -m pipeline.run --help` prints: usage, every parameter, and exit codes."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence

from pipeline.config.conf_files import group_choices
from pipeline.config.parameter_table import Row, Section, sections
from pipeline.exit_codes import MEANINGS

WIDTH = 100
HELP = frozenset({"--help", "-h"})

USAGE = """\
usage: python -m pipeline.run [+dataset=NAME] [name=value …] [--plan | --explain] [-m]

Mine a collection of silhouettes for pairs that turn inside out into each other. Tables and a report
go to outputs/DATASET/. Without +dataset the embedded sample is mined. The same command resumes a
run that was stopped, and computes only what is not in the store.
"""

FLAGS = {
    "--plan": "Show what would run, and stop.",
    "--explain": "Show why each work item would run, and stop.",
    "-m": "Sweep: run each combination of values such as trunks.tau_s=0.07,0.1.",
    "--cfg job": "Print the configuration, and stop.",
    "--help": "Print this text, and stop.",
    "--hydra-help": "Print the flags of Hydra, which reads the command line, and stop.",
}


def wants_help(arguments: Sequence[str]) -> bool:
    """Whether a command line asks for this text."""
    return not HELP.isdisjoint(arguments)


def help_text() -> str:
    """The whole text, at most `WIDTH` columns wide.

    >>> print(help_text().splitlines()[0])
    usage: python -m pipeline.run [+dataset=NAME] [name=value …] [--plan | --explain] [-m]
    """
    lines = [usage_text(), "parameters, each with its default as name=value:", ""]
    for section in sections():
        lines += [*_section_lines(section), ""]
    return "\n".join([*lines, *_exit_code_lines()])


def usage_text() -> str:
    """The first part: usage, flags, and what there is to choose from."""
    choices = {f"{group}=": " | ".join(names) for group, names in group_choices().items()}
    return "\n".join([USAGE, "flags:", *_listed(FLAGS), "", "choices:", *_listed(choices), ""])


def _exit_code_lines() -> Iterator[str]:
    yield "exit codes, of a sweep the greatest of its jobs:"
    yield from _listed({str(code): meaning for code, meaning in MEANINGS.items()})


def _listed(meanings: dict[str, str]) -> Iterator[str]:
    column = max(map(len, meanings)) + 4
    for name, meaning in meanings.items():
        yield textwrap.fill(meaning, WIDTH, initial_indent=f"  {name}".ljust(column), subsequent_indent=" " * column)


def _section_lines(section: Section) -> Iterator[str]:
    yield textwrap.fill(f"{section.name or 'run'}: {section.meaning}", WIDTH)
    for row in section.rows:
        yield _wrapped(f"{row.name}={row.default}  ({_allowed(row)}; {row.source})", "  ")
        yield _wrapped(row.meaning, "      ")


def _wrapped(text: str, indent: str) -> str:
    return textwrap.fill(text, WIDTH, initial_indent=indent, subsequent_indent="      ", break_on_hyphens=False)


def _allowed(row: Row) -> str:
    return ", ".join(filter(None, [row.type, f"{row.range} {row.unit}".strip()]))

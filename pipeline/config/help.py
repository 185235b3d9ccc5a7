"""What `--help` of `riot mine` and of a study prints of parameters, and the names that ``name=value`` may have."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence

from pipeline.config.conf_files import group_choices
from pipeline.config.parameter_table import Row, Section, group_rows, sections
from riot.cli.parser import Parser, columns, listing
from riot.parameters import ParameterGroup

Choices = Mapping[str, Sequence[str]]


def add_assignments(parser: Parser, names: Callable[[], Choices]) -> None:
    """Let a command take ``name=value``; ``names`` gives all names, each with the values that it can be chosen from."""
    parser.add_argument("assignments", nargs="*", metavar="name=value", help="parameters, listed below")
    parser.names = names


def run_names() -> Choices:
    """Names that a command line of a run may give a value to, and values to choose from.

    >>> run_names()["select"]
    ['global', 'paper', 'varied']
    """
    choices = group_choices()
    data = {"+dataset": choices.pop("dataset")}
    return {**data, **choices, **{row.name: row.values for section in sections() for row in section.rows}}


def run_sections() -> str:
    """Choices and every parameter of a run."""
    choices = {f"{group}=": " | ".join(names) for group, names in group_choices().items()}
    blocks = ["\n".join(_section_lines(section)) for section in sections()]
    return "\n".join(
        [listing("choices", choices), "parameters, each with its default as name=value:\n", "\n\n".join(blocks), ""]
    )


def group_section(title: str, group: type[ParameterGroup]) -> str:
    """The parameters of one group."""
    rows = list(group_rows(group, ""))
    lines = [line for row in rows for line in _row_lines(row)] or ["  none"]
    return "\n".join([f"{title}:", *lines, ""])


def _section_lines(section: Section) -> Iterator[str]:
    yield textwrap.fill(f"{section.name or 'run'}: {section.meaning}", columns())
    for row in section.rows:
        yield from _row_lines(row)


def _row_lines(row: Row) -> Iterator[str]:
    yield _wrapped(f"{row.name}={row.default}  ({_allowed(row)}; {row.source})", "  ")
    yield _wrapped(row.meaning, "      ")


def _wrapped(text: str, indent: str) -> str:
    return textwrap.fill(text, columns(), initial_indent=indent, subsequent_indent="      ", break_on_hyphens=False)


def _allowed(row: Row) -> str:
    return ", ".join(filter(None, [row.type, f"{row.range} {row.unit}".strip()]))

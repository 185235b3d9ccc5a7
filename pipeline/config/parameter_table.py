"""Every parameter of a run with its type, default, unit, range, meaning and source: for `--help` and for the guide."""

from __future__ import annotations

import dataclasses
import html
import inspect
import typing
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal, get_type_hints

from pipeline.config.conf_files import group_choices, parameter_groups
from pipeline.config.schema import Config
from riot.parameters import ParameterGroup
from riot.parameters.field import describe, type_name

HEADER = "| parameter | default | allowed | meaning | source |\n|---|---|---|---|---|"


@dataclass(frozen=True)
class Row:
    """A parameter in words; ``name`` is what a command line gives a value to."""

    name: str
    type: str
    default: str
    unit: str
    range: str
    meaning: str
    source: str
    values: tuple[str, ...] = ()
    """All values that it can take, if these are words."""


@dataclass(frozen=True)
class Section:
    """A group of parameters: its name (empty for those of the run as a whole), what it is for, choices from `conf/`."""

    name: str
    meaning: str
    choices: tuple[str, ...]
    rows: tuple[Row, ...]


def sections() -> list[Section]:
    """All groups in the order of the schema, after the parameters that are in no group.

    >>> [section.name for section in sections()][:4]
    ['', 'dataset', 'shape', 'reversibility']
    """
    choices = group_choices()
    return [Section("", _meaning(Config), (), tuple(group_rows(Config, "")))] + [
        Section(name, _meaning(group), tuple(choices.get(name, ())), tuple(group_rows(group, f"{name}.")))
        for name, group in parameter_groups().items()
    ]


def parameter_table() -> str:
    """The guide's Markdown: a heading and a table for each group."""
    return "\n".join(line for section in sections() for line in _markdown(section))


def markdown_cell(text: str) -> str:
    """Text as it stands in a cell of a Markdown table.

    >>> markdown_cell("a|b")
    'a&#124;b'
    """
    return html.escape(text, quote=False).translate({ord(mark): f"&#{ord(mark)};" for mark in "|*_[`\\"})


def group_rows(group: type[ParameterGroup], prefix: str) -> Iterator[Row]:
    """The parameters of a group, each named as ``prefix`` and its name.

    >>> from pipeline.config.schema import SelectConfig
    >>> next(group_rows(SelectConfig, "select.")).name
    'select.policy'
    """
    kinds = get_type_hints(group)
    for field in dataclasses.fields(group):
        declared = describe(field)
        if declared is not None:
            yield Row(
                prefix + field.name,
                type_name(kinds[field.name]),
                _default(field.default),
                declared.unit,
                declared.range,
                declared.meaning,
                declared.source,
                _values(kinds[field.name]),
            )


def _values(kind: Any) -> tuple[str, ...]:
    if kind is bool:
        return ("true", "false")
    return tuple(map(str, typing.get_args(kind))) if typing.get_origin(kind) is Literal else ()


def _default(value: Any) -> str:
    """A default as a command line writes it."""
    if value is None or isinstance(value, bool):
        return {None: "null", True: "true", False: "false"}[value]
    return "[]" if value == () else str(value)


def _meaning(group: type[ParameterGroup]) -> str:
    return " ".join((inspect.getdoc(group) or "").split())


def _markdown(section: Section) -> Iterator[str]:
    yield from (f"## {section.name or 'The run'}", "", section.meaning, "")
    if section.choices:
        yield from ("Choices: " + ", ".join(f"`{section.name}={choice}`" for choice in section.choices) + ".", "")
    yield HEADER
    for row in section.rows:
        default, allowed = f"{row.default} {row.unit}".rstrip(), ", ".join(filter(None, (row.type, row.range)))
        cells = (default, allowed, row.meaning, row.source)
        yield f"| `{row.name}` | {' | '.join(map(markdown_cell, cells))} |"
    yield ""

"""The parameters of fabrication as options of a command: ``--pin`` is ``pin_mm``. Ours."""

from __future__ import annotations

import argparse
from collections.abc import Collection
from dataclasses import fields

from riot.cli.parser import Parser
from riot.parameters import FabricationParameters
from riot.parameters.field import describe


def add_sizes(parser: Parser, without: Collection[str] = ()) -> None:
    """Add an option for every parameter except those ``without`` one, which the command decides itself."""
    for field in fields(FabricationParameters):
        if field.name not in without:
            declared = describe(field)
            assert declared is not None
            parser.parameter_option(
                _option(field.name),
                field.name,
                type=float,
                metavar="MM",
                help=f"{declared.meaning} {declared.range}, default {field.default:g}",
            )


def chosen_sizes(chosen: argparse.Namespace) -> FabricationParameters:
    """Return the parameters that the user gave, and defaults for the others.

    Raises `riot.errors.ParameterError` for a value out of its range.
    """
    given = {field.name: getattr(chosen, field.name, None) for field in fields(FabricationParameters)}
    return FabricationParameters(**{name: value for name, value in given.items() if value is not None})


def _option(parameter: str) -> str:
    return f"--{parameter.removesuffix('_mm').replace('_', '-')}"

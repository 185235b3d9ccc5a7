"""The parameters of fabrication as options of a command: ``--pin`` is ``pin_mm``. Ours."""

from __future__ import annotations

import argparse
import re
from collections.abc import Collection
from dataclasses import fields

from riot.parameters import FabricationParameters
from riot.parameters.field import describe


def add_sizes(parser: argparse.ArgumentParser, without: Collection[str] = ()) -> None:
    """Add an option for every parameter except those ``without`` one, which the command decides itself."""
    for field in fields(FabricationParameters):
        if field.name not in without:
            declared = describe(field)
            assert declared is not None
            parser.add_argument(
                _option(field.name),
                dest=field.name,
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


def name_options(message: str) -> str:
    """Name in a message the option that the user types instead of the parameter of fabrication.

    Examples
    --------
    >>> name_options("enlarge size_mm (30) or thin pin_mm (8)")
    'enlarge --size (30) or thin --pin (8)'
    """
    names = "|".join(field.name for field in fields(FabricationParameters))
    return re.sub(rf"\b({names})\b", lambda match: _option(match[0]), message)


def _option(parameter: str) -> str:
    return f"--{parameter.removesuffix('_mm').replace('_', '-')}"

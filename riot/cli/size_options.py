"""The parameters of fabrication as options of a command: ``--pin`` is ``pin_mm``. Ours."""

from __future__ import annotations

import argparse
from collections.abc import Collection
from dataclasses import fields

from riot.cli.parser import Parser
from riot.cli.profiles import profile, shipped_in_words
from riot.parameters import FabricationParameters
from riot.parameters.fabrication import PIVOTS
from riot.parameters.field import describe


def add_sizes(parser: Parser, without: Collection[str] = ()) -> None:
    """Add an option for every parameter except those ``without`` one, which the command decides itself."""
    parser.parameter_option(
        "--profile",
        "profile",
        metavar="NAME[,NAME]",
        help="parameters of a machine, of a laser and its material (k40,plywood-3mm), or your own in makers.toml; "
        f"there are {shipped_in_words()}",
    )
    for field in fields(FabricationParameters):
        if field.name in without:
            continue
        declared = describe(field)
        assert declared is not None
        if field.name == "pivot":
            parser.parameter_option(
                "--pivot",
                field.name,
                choices=tuple(PIVOTS),
                help="what the hinges turn on: printed pins, lengths of 1.75 mm filament or of a 3 mm steel rod with "
                "printed caps, M3 screws of 10 mm with nuts, or cones printed in place; default "
                "printed",
            )
        else:
            parser.parameter_option(
                _option(field.name),
                field.name,
                type=float,
                metavar="MM",
                help=f"{declared.meaning} {declared.range}, default {field.default:g}",
            )


def chosen_sizes(chosen: argparse.Namespace) -> FabricationParameters:
    """Return the parameters that the user gave, then the profile's, then those that go with the pivot, then defaults.

    Raises `riot.errors.ParameterError` for a value out of its range, and what `profile` raises.
    """
    options = {field.name: getattr(chosen, field.name, None) for field in fields(FabricationParameters)}
    given = {name: value for name, value in options.items() if value is not None}
    machine = dict(profile(chosen.profile)) if getattr(chosen, "profile", None) else {}
    pivot = machine.pop("pivot", "printed")
    preset = PIVOTS[given.pop("pivot", pivot)]
    return FabricationParameters(**{**preset, **machine, **given})


def _option(parameter: str) -> str:
    return f"--{parameter.removesuffix('_mm').replace('_', '-')}"

"""What a person can set when a puzzle is made: the parameters of fabrication, and presets of them."""

from __future__ import annotations

from dataclasses import fields
from typing import get_args, get_type_hints

from msgspec import Struct

from riot.parameters import FabricationParameters, allowed_range
from riot.parameters.fabrication import PIVOTS
from riot.parameters.field import describe

Value = float | int | bool | str


class Setting(Struct, frozen=True):
    """A parameter: its default, and its range if it is a number, or its choices if it is a word."""

    name: str
    value: Value
    least: float | None
    greatest: float | None
    choices: list[str]
    unit: str
    meaning: str


class Preset(Struct, frozen=True):
    """Values that go together."""

    name: str
    values: dict[str, Value]


class Settings(Struct, frozen=True):
    """All of them."""

    settings: list[Setting]
    presets: list[Preset]


PRESETS = [
    Preset("3D printer", {}),
    Preset("3D printer, pins of filament", dict(PIVOTS["filament"])),
    Preset("3D printer, steel pins", dict(PIVOTS["rod"])),
    Preset("3D printer, M3 screws", dict(PIVOTS["screw"])),
    Preset("fine 3D printer", {"layer_mm": 0.1, "clearance_mm": 0.25, "gap_mm": 0.25}),
    Preset("laser cutter", {"kerf_mm": 0.15, "thickness_mm": 6.0, "gap_mm": 0.2}),
]
"""Ours, from makers' literature, as the defaults of the parameters are; not tried on machines."""


def settings() -> Settings:
    """The parameters of fabrication with their ranges, and presets.

    >>> settings().settings[0].name, settings().settings[0].least
    ('size_mm', 30.0)
    """
    hints = get_type_hints(FabricationParameters)
    listed = []
    for field in fields(FabricationParameters):
        declared = describe(field)
        if declared is None:
            continue
        number = hints[field.name] in (float, int)
        least, greatest = allowed_range(FabricationParameters, field.name) if number else (None, None)
        choices = [value for value in get_args(hints[field.name]) if isinstance(value, str)]
        listed.append(
            Setting(
                field.name,
                getattr(FabricationParameters, field.name),
                least,
                greatest,
                choices,
                declared.unit,
                declared.meaning,
            )
        )
    return Settings(listed, PRESETS)

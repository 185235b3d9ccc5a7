"""The schema of parameters: every group refuses a wrong value when it is made, and tells what each field means."""

from __future__ import annotations

import dataclasses
import math
import pickle
import typing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import riot.parameters
from riot.errors import ParameterError, RiotError
from riot.parameters import ParameterGroup, parameter
from riot.parameters.field import describe

GROUPS: list[type[ParameterGroup]] = [
    kind
    for kind in (getattr(riot.parameters, name) for name in sorted(riot.parameters.__all__))
    if isinstance(kind, type) and issubclass(kind, ParameterGroup) and kind is not ParameterGroup
]
FIELDS = [(group, field) for group in GROUPS for field in dataclasses.fields(group)]
NUMBERS = [(group, field) for group, field in FIELDS if isinstance(field.default, int | float)]


def named(case: Any) -> str:
    return case.name if isinstance(case, dataclasses.Field) else getattr(case, "__name__", "")


@pytest.mark.parametrize(("group", "field"), FIELDS, ids=named)
def test_every_parameter_has_a_default_a_meaning_and_a_source(
    group: type[ParameterGroup], field: dataclasses.Field[Any]
) -> None:
    declared = describe(field)
    assert declared is not None and declared.meaning.endswith(".") and declared.source
    assert getattr(group(), field.name) == field.default


@pytest.mark.parametrize(("group", "field"), NUMBERS, ids=named)
def test_every_number_has_a_bound_that_is_kept(group: type[ParameterGroup], field: dataclasses.Field[Any]) -> None:
    declared = describe(field)
    assert declared is not None and (declared.above is not None or declared.at_least is not None)
    least = declared.above if declared.above is not None else declared.at_least
    assert least is not None
    outside = least if declared.above is not None else least - 1
    for value in (outside, -math.inf, math.nan, True, None, "1"):
        with pytest.raises(ParameterError) as caught:
            group(**{field.name: value})
        assert caught.value.parameter == field.name and str(caught.value).startswith(f"{field.name}: ")
    with pytest.raises(ParameterError, match=f"{field.name}: must be {declared.range}"):
        group(**{field.name: outside})
    if declared.at_most is not None:
        with pytest.raises(ParameterError, match=f"got {math.ceil(declared.at_most) + 1}"):
            group(**{field.name: math.ceil(declared.at_most) + 1})


def test_numbers_become_plain_ones() -> None:
    spacing = riot.parameters.TrunkParameters(spacing=20, max_vertices=np.int64(7)).spacing  # type: ignore[arg-type]
    assert type(spacing) is float and spacing == 20.0
    assert type(riot.parameters.CrsParameters(sigma_e=np.float32(0.5)).sigma_e) is float  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("group", "values", "words"),
    [
        ("TrunkParameters", {"spacing": -1, "tau_c": 7}, "spacing: must be greater than 0, got -1"),
        ("TrunkParameters", {"max_vertices": 2}, "max_vertices: must be 3 or more, got 2"),
        ("ReversibilityParameters", {"waist_low": 5, "waist_high": 1}, "waist_low: must be less than waist_high"),
        ("ConstructParameters", {"method": "best"}, "method: 'best' is not allowed; choose one of exact, laplacian"),
        ("FabricationParameters", {"pin_mm": 9}, "pin_mm: must be 1.75 to 8 mm, got 9"),
        ("CrsParameters", {"lines": 1.5}, "lines: expected a whole number, got 1.5"),
    ],
)
def test_messages_name_field_range_unit_and_value(group: str, values: dict[str, Any], words: str) -> None:
    with pytest.raises(RiotError, match=words) as caught:
        getattr(riot.parameters, group)(**values)
    assert isinstance(caught.value, ValueError)
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)


def test_types_are_those_that_are_written() -> None:
    for group, field in FIELDS:
        kind = typing.get_type_hints(group)[field.name]
        assert kind in (int, float) or typing.get_origin(kind) in (typing.Literal, tuple)


def parse_folder(value: Any) -> Path:
    if isinstance(value, str | Path) and str(value):
        return Path(value)
    raise ValueError(f"expected a path, got {value!r}")


@dataclass(frozen=True)
class Settings(ParameterGroup):
    """A parameter of each kind that is no plain number."""

    folder: Path = parameter(Path("here"), parse=parse_folder, meaning="A path.")
    limit: int | None = parameter(None, at_least=1, unit="items", meaning="A number or null.")
    widths: tuple[float, ...] = parameter((1.0,), above=0, meaning="A list of numbers.")
    fast: bool = parameter(False, meaning="A flag.")


def test_every_kind_of_value_is_taken_in_the_form_of_a_command_line() -> None:
    settings = Settings(folder="there", limit=3, widths=[1, 2.5], fast=True)  # type: ignore[arg-type]
    assert settings == Settings(Path("there"), 3, (1.0, 2.5), True)
    assert all(type(width) is float for width in settings.widths)
    assert dataclasses.replace(settings, limit=None).limit is None and Settings(widths=()).widths == ()


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"folder": ""}, "folder: expected a path, got ''"),
        ({"folder": None}, "folder: expected a path, got None"),
        ({"limit": 0}, "limit: must be 1 or more items, or null, got 0"),
        ({"limit": "3"}, "limit: expected a whole number or null, got '3'"),
        ({"widths": [1.0, -2]}, "widths[1]: must be greater than 0, got -2"),
        ({"widths": [1.0, "a"]}, "widths[1]: expected a number, got 'a'"),
        ({"widths": 1.0}, "widths: expected a list such as [a,b], got 1.0"),
        ({"fast": 1}, "fast: expected true or false, got 1"),
    ],
)
def test_a_wrong_value_of_any_kind_is_named(values: dict[str, Any], message: str) -> None:
    with pytest.raises(ParameterError) as caught:
        Settings(**values)
    assert str(caught.value) == message

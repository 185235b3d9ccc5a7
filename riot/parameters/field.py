"""How a parameter is declared and checked: type, default, bounds, unit, meaning and source in one place. Ours.

A group of parameters is a frozen dataclass that inherits from `ParameterGroup`; each of its fields is declared by
`parameter`. A group checks every value when it is made, so that no group with a wrong value exists.
"""

from __future__ import annotations

import dataclasses
import math
import types
import typing
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from functools import cache
from numbers import Integral, Real
from pathlib import Path
from typing import Any, Literal, TypeVar

from riot.errors import ParameterError

T = TypeVar("T")

_KEY = "parameter"
_TYPE_NAMES: dict[Any, str] = {
    float: "a number",
    int: "a whole number",
    bool: "true or false",
    str: "text",
    Path: "a path",
    type(None): "null",
}


@dataclass(frozen=True)
class Parameter:
    """What a parameter means, and which values it can take; a bound of None does not exist.

    ``parse`` makes the value of what was given, before its type is checked; it raises ValueError for what it cannot be.
    """

    meaning: str
    unit: str
    source: str
    above: float | None = None
    at_least: float | None = None
    at_most: float | None = None
    below: float | None = None
    parse: Callable[[Any], Any] | None = None

    @property
    def range(self) -> str:
        """The allowed values in words, such as ``greater than 0 and at most 1``; empty if there is no bound."""
        if self.at_least is not None and self.at_most is not None:
            return f"{self.at_least:g} to {self.at_most:g}"
        words = []
        if self.above is not None:
            words.append(f"greater than {self.above:g}")
        if self.at_least is not None:
            words.append(f"{self.at_least:g} or more")
        if self.at_most is not None:
            words.append(f"at most {self.at_most:g}")
        if self.below is not None:
            words.append(f"less than {self.below:g}")
        return " and ".join(words)

    def allows(self, value: float) -> bool:
        """Whether a finite number is within the bounds."""
        return (
            (self.above is None or value > self.above)
            and (self.at_least is None or value >= self.at_least)
            and (self.at_most is None or value <= self.at_most)
            and (self.below is None or value < self.below)
        )


def parameter(
    default: T,
    *,
    meaning: str,
    unit: str = "",
    source: str = "ours",
    above: float | None = None,
    at_least: float | None = None,
    at_most: float | None = None,
    below: float | None = None,
    parse: Callable[[Any], T] | None = None,
) -> T:
    """Declare a field of a `ParameterGroup`.

    ``unit`` is ``mm``, ``L_c``, ``D_c``, ``pixels`` or alike, empty for a plain number; ``source`` is a section of the
    paper, a citation, or ``ours``. ``above`` and ``below`` exclude the bound, ``at_least`` and ``at_most`` include it.
    ``parse`` makes a value of text, for types that a command line cannot write, such as a path.
    """
    declared = Parameter(meaning, unit, source, above, at_least, at_most, below, parse)
    field: Any = dataclasses.field(default=default, metadata={_KEY: declared})
    return typing.cast("T", field)


@dataclass(frozen=True)
class ParameterGroup:
    """Parameters that belong together, checked when they are made.

    Raises `riot.errors.ParameterError` for a wrong type, a number that is not finite, or a value out of its range.

    >>> from riot.parameters import TrunkParameters
    >>> TrunkParameters(spacing=20).spacing
    20.0
    >>> TrunkParameters(spacing=-1)
    Traceback (most recent call last):
    riot.errors.ParameterError: spacing: must be greater than 0, got -1
    """

    def __post_init__(self) -> None:
        hints = type_hints(typing.cast("Hashable", type(self)))
        for field in dataclasses.fields(self):
            value = check_value(field.name, hints[field.name], describe(field), getattr(self, field.name))
            object.__setattr__(self, field.name, value)
        self.check_together()

    def check_together(self) -> None:
        """Check what holds between several parameters; raises `riot.errors.ParameterError`."""


def describe(field: dataclasses.Field[Any]) -> Parameter | None:
    """What was declared of a field, None if it is a group of parameters."""
    return field.metadata.get(_KEY)


def allowed_range(group: type[ParameterGroup], name: str) -> tuple[float, float]:
    """Least and greatest value of a parameter, infinite where it has no such bound.

    >>> from riot.parameters import FabricationParameters
    >>> allowed_range(FabricationParameters, "pin_mm")
    (1.75, 8.0)
    """
    (field,) = (field for field in dataclasses.fields(group) if field.name == name)
    declared = describe(field)
    assert declared is not None
    least = declared.at_least if declared.at_least is not None else declared.above
    greatest = declared.at_most if declared.at_most is not None else declared.below
    return (-math.inf if least is None else float(least), math.inf if greatest is None else float(greatest))


def check_value(name: str, kind: Any, declared: Parameter | None, value: Any) -> Any:
    """The value as its type has it: a whole number for a float parameter becomes a float, a list a tuple.

    The bounds of a list are those of each entry. Raises `riot.errors.ParameterError`, which names the parameter, what
    is allowed, and the value.

    >>> check_value("spacing", float, None, 20)
    20.0
    """
    if declared is not None and declared.parse is not None:
        try:
            value = declared.parse(value)
        except ValueError as error:
            raise ParameterError(name, str(error)) from error
    kinds = typing.get_args(kind) if typing.get_origin(kind) in (typing.Union, types.UnionType) else (kind,)
    for option in kinds:
        if typing.get_origin(option) is Literal:
            if not isinstance(value, bool) and value in typing.get_args(option):
                return value
        elif typing.get_origin(option) is tuple:
            if isinstance(value, list | tuple):
                item = typing.get_args(option)[0]
                of_entry = None if declared is None else dataclasses.replace(declared, parse=None)
                return tuple(
                    check_value(f"{name}[{index}]", item, of_entry, entry) for index, entry in enumerate(value)
                )
        elif _is_instance(value, option):
            if option in (float, int):
                _check_number(name, declared, type(None) in kinds, value)
                return option(value)
            return value
    raise ParameterError(name, _wrong_type(kinds, value))


def _is_instance(value: Any, kind: Any) -> bool:
    if kind in (float, int):
        return isinstance(value, Real if kind is float else Integral) and not isinstance(value, bool)
    return isinstance(value, kind)


def _check_number(name: str, declared: Parameter | None, optional: bool, value: float) -> None:
    null = ", or null" if optional else ""
    if not math.isfinite(value):
        raise ParameterError(name, f"must be a finite number{null}, got {value}")
    if declared is not None and not declared.allows(value):
        unit = f" {declared.unit}" if declared.unit else ""
        raise ParameterError(name, f"must be {declared.range}{unit}{null}, got {value}")


def _wrong_type(kinds: Sequence[Any], value: Any) -> str:
    if typing.get_origin(kinds[0]) is Literal:
        return f"{value!r} is not allowed; choose one of {', '.join(map(str, typing.get_args(kinds[0])))}"
    return f"expected {' or '.join(type_name(kind) for kind in kinds)}, got {value!r}"


def type_name(kind: Any) -> str:
    """A type in words, such as ``a whole number or null``.

    >>> type_name(float), type_name(int)
    ('a number', 'a whole number')
    """
    if typing.get_origin(kind) in (typing.Union, types.UnionType):
        return " or ".join(type_name(option) for option in typing.get_args(kind))
    if typing.get_origin(kind) is Literal:
        return " or ".join(map(str, typing.get_args(kind)))
    if typing.get_origin(kind) is tuple:
        return "a list such as [a,b]"
    if isinstance(kind, type) and issubclass(kind, ParameterGroup):
        return "a group of parameters"
    return str(_TYPE_NAMES.get(kind) or getattr(kind, "TYPE_NAME", f"a {getattr(kind, '__name__', kind)}"))


@cache
def type_hints(group: Hashable) -> dict[str, Any]:
    """The type of each field of a group."""
    return typing.get_type_hints(group)

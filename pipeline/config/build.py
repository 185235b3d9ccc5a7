"""The configuration of a run, or any group of parameters, made of plain values; messages name what is allowed."""

from __future__ import annotations

import dataclasses
import difflib
import typing
from collections.abc import Hashable, Mapping
from typing import Any, TypeVar

from pipeline.config.schema import Config
from pipeline.errors import ConfigError
from riot.parameters.field import check_value, describe, type_hints

T = TypeVar("T")


def make_config(values: Mapping[str, Any]) -> Config:
    """Build the typed configuration from plain values (nested mappings, as Hydra composes them).

    Raises `ConfigError` for an unknown name, a wrong type or a value out of range; the message names what is allowed.

    >>> make_config({"dataset": {"limit": 12}, "select": {"top": 3}}).select.top
    3
    """
    return build(Config, values)


def build(group: type[T], values: Mapping[str, Any], prefix: str = "") -> T:
    """Make a group of parameters, or a dataclass of plain values, from ``values``; ``prefix`` precedes its names.

    Raises `ConfigError` as `make_config` does.

    >>> from pipeline.config.schema import SelectConfig
    >>> build(SelectConfig, {"top": 0}, "select.")
    Traceback (most recent call last):
    pipeline.errors.ConfigError: select.top: must be 1 or more, got 0
    """
    hints = type_hints(typing.cast("Hashable", group))
    fields = {field.name: field for field in dataclasses.fields(group)}  # type: ignore[arg-type]
    for name in sorted(str(name) for name in values):
        if name not in fields:
            raise ConfigError(unknown_name(prefix + name, [prefix + known for known in fields]))
    for name, known in fields.items():
        if name not in values and known.default is known.default_factory is dataclasses.MISSING:
            raise ConfigError(f"{prefix}{name}: a value is needed; give {prefix}{name}=…")
    try:
        return group(
            **{
                name: build(hints[name], value, f"{prefix}{name}.")
                if dataclasses.is_dataclass(hints[name]) and isinstance(value, Mapping)
                else check_value(name, hints[name], describe(fields[name]), value)
                for name, value in values.items()
            }
        )
    except ConfigError:
        raise
    except ValueError as error:  # of a group that checks itself, and names the parameter first
        raise ConfigError(f"{prefix}{error}") from error


def unknown_name(name: str, allowed: list[str]) -> str:
    """The message for a name that does not exist: the nearest name, and all names."""
    nearest = difflib.get_close_matches(name, allowed, n=1)
    hint = f" Did you mean {nearest[0]}?" if nearest else ""
    return f"{name}: no such parameter.{hint} Allowed: {', '.join(sorted(allowed))}"

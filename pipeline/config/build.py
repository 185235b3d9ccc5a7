"""The configuration of a run, or any group of parameters, made of plain values; messages name what is allowed."""

from __future__ import annotations

import dataclasses
import difflib
from collections.abc import Mapping
from typing import Any, TypeVar, get_type_hints

from pipeline.config.schema import Config
from pipeline.errors import ConfigError
from riot.errors import ParameterError
from riot.parameters.field import ParameterGroup, describe

Group = TypeVar("Group", bound=ParameterGroup)


def make_config(values: Mapping[str, Any]) -> Config:
    """Build the typed configuration from plain values (nested mappings, as Hydra composes them).

    Raises `ConfigError` for an unknown name, a wrong type or a value out of range; the message names what is allowed.

    >>> make_config({"dataset": {"limit": 12}, "select": {"top": 3}}).select.top
    3
    """
    return build(Config, values)


def build(group: type[Group], values: Mapping[str, Any], prefix: str = "") -> Group:
    """Make a group of parameters, and the groups in it, of ``values``; ``prefix`` precedes names in messages.

    Raises `ConfigError` as `make_config` does.

    >>> from pipeline.config.schema import SelectConfig
    >>> build(SelectConfig, {"top": 0}, "select.")
    Traceback (most recent call last):
    pipeline.errors.ConfigError: select.top: must be 1 or more, got 0
    """
    kinds = get_type_hints(group)
    fields = {field.name: field for field in dataclasses.fields(group)}
    for name in sorted(str(name) for name in values):
        if name not in fields:
            raise ConfigError(unknown_name(prefix + name, [prefix + known for known in fields]))
    for name, field in fields.items():
        if name not in values and field.default is field.default_factory is dataclasses.MISSING:
            raise ConfigError(f"{prefix}{name}: a value is needed; give {prefix}{name}=…")
    nested = {
        name: build(kinds[name], value, f"{prefix}{name}.")
        for name, value in values.items()
        if describe(fields[name]) is None and isinstance(value, Mapping)
    }
    try:
        return group(**{**values, **nested})
    except ParameterError as error:
        raise ConfigError(f"{prefix}{error}") from error


def unknown_name(name: str, allowed: list[str]) -> str:
    """The message for a name that does not exist: the nearest name, and all names."""
    nearest = difflib.get_close_matches(name, allowed, n=1)
    hint = f" Did you mean {nearest[0]}?" if nearest else ""
    return f"{name}: no such parameter.{hint} Allowed: {', '.join(sorted(allowed))}"

"""The command line, checked before any work: names, types and values, with what is allowed in the message."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from hydra import compose, initialize_config_dir
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import Override
from hydra.errors import HydraException
from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException

from pipeline.config import Config, make_config, unknown_name
from pipeline.errors import ConfigError

CONF = Path(__file__).resolve().parent.parent / "conf"
HYDRA_BASE = "1.3"
SUGAR = {"--plan": "plan=true", "--explain": "explain=true"}
SWEEP = frozenset({"-m", "--multirun"})
NO_DATASET = "+dataset=sample"


def complete(arguments: Sequence[str]) -> list[str]:
    """Spell out what the command line leaves unsaid: flags of ours as values, ``+`` before ``dataset=``, the sample."""
    spelled = [SUGAR.get(argument, argument) for argument in arguments]
    spelled = ["+" + argument if argument.startswith("dataset=") else argument for argument in spelled]
    if not any(argument.startswith("+dataset=") for argument in spelled):
        spelled.append(NO_DATASET)
    # Hydra's parser takes values in one stretch only, so that flags go first.
    return sorted(spelled, key=lambda argument: not argument.startswith("-")) if is_plain(spelled) else spelled


def is_multirun(arguments: Sequence[str]) -> bool:
    """Whether this is a sweep."""
    return any(argument in SWEEP for argument in arguments)


def is_plain(arguments: Sequence[str]) -> bool:
    """Whether all flags are known here; with any other (``--help``, ``--cfg`` …) the command is Hydra's alone."""
    return all(argument in SWEEP or not argument.startswith("-") for argument in arguments)


def check_command(arguments: Sequence[str]) -> Config:
    """The typed configuration of a command line; of a sweep, that of its first point.

    Raises `ConfigError` for an unknown name or group, or a wrong type or value.
    """
    try:
        overrides = OverridesParser.create().parse_overrides([one for one in arguments if one not in SWEEP])
    except HydraException as error:
        raise ConfigError(f"cannot read the command line: {error}") from error
    for override in overrides:
        _check_name(override)
    lines = [_first_point(override) if is_multirun(arguments) else str(override.input_line) for override in overrides]
    try:
        with initialize_config_dir(version_base=HYDRA_BASE, config_dir=str(CONF)):
            return make_typed(compose("config", overrides=lines))
    except (HydraException, OmegaConfBaseException) as error:
        raise ConfigError(str(error).strip()) from error


def make_typed(composed: DictConfig) -> Config:
    """Turn Hydra's configuration into ours at once; raises `ConfigError`."""
    try:
        values = OmegaConf.to_container(composed, resolve=True, throw_on_missing=True)
    except OmegaConfBaseException as error:
        raise ConfigError(str(error).strip()) from error
    assert isinstance(values, dict)
    return make_config({str(name): value for name, value in values.items()})


def _check_name(override: Override) -> None:
    name = override.key_or_group
    if name == "hydra" or name.startswith(("hydra.", "hydra/")):
        return
    choices = group_choices()
    if name in choices:
        value = override.value()
        known = isinstance(value, str) and value in choices[name]
        if not known and not override.is_sweep_override() and not isinstance(value, dict):
            raise ConfigError(f"{name}={value}: no such choice; allowed: {', '.join(choices[name])}")
        return
    group, _, parameter = name.partition(".")
    allowed = allowed_names()
    within = [one for one in allowed if one.startswith(group + ".")]
    if name not in allowed:
        raise ConfigError(unknown_name(name, within if parameter and within else allowed))


def allowed_names() -> list[str]:
    """Every parameter that a command line may set, as ``group.name``."""
    names: list[str] = []
    hints = _field_types()
    for name, kind in hints.items():
        if dataclasses.is_dataclass(kind):
            names += [f"{name}.{field.name}" for field in dataclasses.fields(kind)]
        else:
            names.append(name)
    return names


def group_choices() -> dict[str, list[str]]:
    """Groups of the configuration, and the files to choose from in each."""
    return {
        folder.name: sorted(file.stem for file in folder.glob("*.yaml"))
        for folder in sorted(CONF.iterdir())
        if folder.is_dir()
    }


def _field_types() -> dict[str, Any]:
    import typing

    return typing.get_type_hints(Config)


def _first_point(override: Override) -> str:
    if not override.is_sweep_override():
        return str(override.input_line)
    first = next(iter(override.sweep_string_iterator()))
    prefix = "+" if override.is_add() else ""
    return f"{prefix}{override.key_or_group}={first}"

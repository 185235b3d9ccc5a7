"""The command line, checked before any work: names, types and values, with what is allowed in the message."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Sequence
from pathlib import Path
from typing import get_type_hints

from hydra import compose, initialize_config_dir
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import Override
from hydra.errors import HydraException
from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException

from pipeline.config.build import make_config, unknown_name
from pipeline.config.schema import Config
from pipeline.errors import ConfigError
from pipeline.store.keys import digest_text

CONF = Path(__file__).resolve().parents[2] / "conf"
HYDRA_BASE = "1.3"
SUGAR = {"--plan": "plan=true", "--explain": "explain=true"}
SWEEP = frozenset({"-m", "--multirun"})
NO_DATASET = "+dataset=sample"
NAME_LENGTH = 200


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

    Raises `ConfigError` for an unknown name or group, or a wrong type or value, of a sweep in any of its values.
    """
    overrides = _parse(arguments)
    for override in overrides:
        _check_name(override)
    _check_dataset(overrides)
    if not is_multirun(arguments):
        return _compose([str(override.input_line) for override in overrides])
    values = [_values(override) for override in overrides]
    first = [of[0] for of in values]
    config = _compose(first)
    for place, of in enumerate(values):
        for other in of[1:]:
            _compose([*first[:place], other, *first[place + 1 :]])
    return config


def swept_over(arguments: Sequence[str]) -> frozenset[str]:
    """Names of the parameters and groups that a command line sweeps over."""
    return frozenset(override.key_or_group for override in _parse(arguments) if override.is_sweep_override())


def sweep_values(arguments: Sequence[str], chosen: Sequence[str]) -> dict[str, bool | int | float | str | None]:
    """Value of everything that ``arguments`` sweep over in the job whose overrides are ``chosen``, by name."""
    swept = swept_over(arguments)
    values = {one.key_or_group: one.value() for one in _parse(chosen) if one.key_or_group in swept}
    return {name: one if isinstance(one, bool | int | float | None) else str(one) for name, one in values.items()}


def sweep_point(arguments: Sequence[str], chosen: Sequence[str]) -> str:
    """Folder name of one point of a sweep: those of its ``chosen`` overrides that ``arguments`` sweep over.

    Data sets and outputs have folders of their own, and are left out; empty when nothing else is swept over. What a
    folder cannot be named is replaced, and told apart by a digest.
    """
    kept = swept_over(arguments) - {"dataset", "dataset.name", "outputs"}
    whole = ",".join(one.lstrip("+") for one in chosen if one.lstrip("+").partition("=")[0] in kept)
    named = re.sub(r"[^\w.=,+-]+", "-", whole)[:NAME_LENGTH]
    return named if named == whole else f"{named}~{digest_text(whole)[:8]}"


def _parse(arguments: Sequence[str]) -> list[Override]:
    try:
        return OverridesParser.create().parse_overrides([one for one in arguments if one not in SWEEP])
    except HydraException as error:
        raise ConfigError(f"cannot read the command line, a list of name=value: {error}") from error


def _compose(lines: list[str]) -> Config:
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
        if not override.is_sweep_override() and isinstance(override.value(), dict):
            return
        for value in (line.partition("=")[2] for line in _values(override)):
            if value not in choices[name]:
                raise ConfigError(f"{name}={value}: no such choice; allowed: {', '.join(choices[name])}")
        return
    group, _, parameter = name.partition(".")
    allowed = allowed_names()
    within = [one for one in allowed if one.startswith(group + ".")]
    if name not in allowed:
        raise ConfigError(unknown_name(name, within if parameter and within else allowed))


def _check_dataset(overrides: Sequence[Override]) -> None:
    """Data sets differ in their parameters, and Hydra's advice for one that is missing (add it) is wrong here."""
    named = [override for override in overrides if override.key_or_group == "dataset"]
    if len(named) > 1:
        raise ConfigError(f"{' '.join(str(one.input_line) for one in named)}: give one data set")
    chosen = [line.partition("=")[2] for line in _values(named[0])]
    for override in overrides:
        group, _, parameter = override.key_or_group.partition(".")
        if group == "dataset" and parameter:
            for name in chosen:
                own = [str(one) for one in OmegaConf.load(CONF / "dataset" / f"{name}.yaml")]
                if parameter not in own:
                    own_names = ", ".join(f"dataset.{one}" for one in own)
                    raise ConfigError(
                        f"dataset.{parameter}: the data set {name} has {own_names} only; "
                        "your own pictures are +dataset=folder dataset.root=DIR"
                    )


def allowed_names() -> list[str]:
    """Every parameter that a command line may set, as ``group.name``."""
    names: list[str] = []
    for name, kind in get_type_hints(Config).items():
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


def _values(override: Override) -> list[str]:
    """An override for each value that it sweeps over; itself, if it does not."""
    if not override.is_sweep_override():
        return [str(override.input_line)]
    prefix = "+" if override.is_add() else ""
    return [f"{prefix}{override.key_or_group}={value}" for value in override.sweep_string_iterator()]

"""The command line, checked before any work: names, types and values, with what is allowed in the message."""

from __future__ import annotations

import re
from collections.abc import Sequence

from pipeline.config.build import make_config, unknown_name
from pipeline.config.conf_files import CONF, allowed_names, group_choices, list_names, parameter_groups
from pipeline.config.schema import Config
from pipeline.errors import ConfigError
from pipeline.store.keys import digest_text
from riot.errors import needs_extra

with needs_extra("mine"):
    from hydra import compose, initialize_config_dir
    from hydra.core.override_parser.overrides_parser import OverridesParser
    from hydra.core.override_parser.types import Override
    from hydra.errors import HydraException
    from omegaconf import DictConfig, OmegaConf
    from omegaconf.errors import OmegaConfBaseException

HYDRA_BASE = "1.3"
SUGAR = {"--plan": "plan=true", "--explain": "explain=true", "--profile": "profile=true"}
WITH = {"select.with=": "select.shapes="}
"""A parameter that goes by another name in Python, of which ``with`` is a word."""
SWEEP = frozenset({"-m", "--multirun"})
NO_DATASET = "+dataset=sample"
NAME_LENGTH = 200


def complete(arguments: Sequence[str]) -> list[str]:
    """Write a command line as Hydra reads it: flags of ours as values, ``+`` before ``dataset=``, else the sample.

    >>> complete(["--plan", "dataset=folder", "dataset.root=pictures"])
    ['plan=true', '+dataset=folder', 'dataset.root=pictures']
    >>> complete(["batch=8", "-m"])
    ['-m', 'batch=8', '+dataset=sample']

    Outside of a sweep, a list needs no brackets.

    >>> complete(["select.classes=bird,fish"])
    ['select.classes=[bird,fish]', '+dataset=sample']
    """
    spelled = [SUGAR.get(argument, argument) for argument in arguments]
    for name, other in WITH.items():
        spelled = [argument.replace(name, other, 1) if argument.startswith(name) else argument for argument in spelled]
    if not is_multirun(arguments):
        spelled = [_with_brackets(argument) for argument in spelled]
    spelled = ["+" + argument if argument.startswith("dataset=") else argument for argument in spelled]
    if not any(argument.startswith("+dataset=") for argument in spelled):
        last = max((index for index, argument in enumerate(spelled) if _is_value(argument)), default=len(spelled) - 1)
        spelled.insert(last + 1, NO_DATASET)
    # Hydra's parser reads values only where no flag stands between them.
    return sorted(spelled, key=lambda argument: not argument.startswith("-")) if is_plain(spelled) else spelled


def is_multirun(arguments: Sequence[str]) -> bool:
    """Whether this is a sweep."""
    return any(argument in SWEEP for argument in arguments)


def is_plain(arguments: Sequence[str]) -> bool:
    """Whether all flags are ours; with another one (``--cfg``, ``--hydra-help`` …) Hydra alone reads the command."""
    return all(argument in SWEEP or not argument.startswith("-") for argument in arguments)


def check_command(arguments: Sequence[str]) -> Config:
    """The typed configuration of a command line; of a sweep, that of its first point.

    Raises `ConfigError` for an unknown name or choice, and for a wrong type or value, in any point of a sweep.

    >>> check_command(complete(["select.top=3"])).select.top
    3
    """
    overrides = _parse(arguments)
    for override in overrides:
        _check_name(override)
    _check_dataset(overrides)
    if not is_multirun(arguments):
        _refuse_commas(overrides)
        return _compose([str(override.input_line) for override in overrides])
    alternatives = [_values(override) for override in overrides]
    first_point = [lines[0] for lines in alternatives]
    config = _compose(first_point)
    for index, lines in enumerate(alternatives):
        for line in lines[1:]:
            _compose([*first_point[:index], line, *first_point[index + 1 :]])
    return config


def check_words(words: Sequence[str]) -> None:
    """Raise `ConfigError` for a word that is no ``name=value``, with the one that may be meant.

    >>> check_words(["mpeg7"])
    Traceback (most recent call last):
    pipeline.errors.ConfigError: mpeg7: no name=value. Did you mean +dataset=mpeg7?
    """
    for word in words:
        if "=" in word or word.startswith("~"):
            continue
        groups = [group for group, choices in group_choices().items() if word in choices]
        meant = [f"{'+' if group == 'dataset' else ''}{group}={word}" for group in groups]
        meant = meant or [f"{name}=…" for name in allowed_names() if word in (name, name.rpartition(".")[2])]
        hint = f" Did you mean {' or '.join(meant)}?" if meant else " Parameters are given as trunks.tau_s=0.1"
        raise ConfigError(f"{word}: no name=value.{hint}")


def swept_over(arguments: Sequence[str]) -> frozenset[str]:
    """Names of the parameters and groups that a command line sweeps over.

    >>> swept_over(["-m", "batch=8,16", "select=paper"])
    frozenset({'batch'})
    """
    return frozenset(override.key_or_group for override in _parse(arguments) if override.is_sweep_override())


def sweep_values(arguments: Sequence[str], chosen: Sequence[str]) -> dict[str, bool | int | float | str | None]:
    """Values of the parameters that ``arguments`` sweep over, by name, in the job whose overrides are ``chosen``.

    >>> sweep_values(["-m", "batch=8,16", "select=paper,global"], ["batch=8", "select=paper"])
    {'batch': 8, 'select': 'paper'}
    """
    swept = swept_over(arguments)
    values = {override.key_or_group: override.value() for override in _parse(chosen)}
    return {
        name: value if isinstance(value, bool | int | float | None) else str(value)
        for name, value in values.items()
        if name in swept
    }


def sweep_point(arguments: Sequence[str], chosen: Sequence[str]) -> str:
    """Folder name of one point of a sweep: those of its ``chosen`` overrides that ``arguments`` sweep over.

    Data sets and outputs have folders of their own and are left out; the name is empty if nothing else is swept over.
    If characters of the overrides cannot stand in the name of a folder, others replace them, and a digest follows.

    >>> sweep_point(["-m", "batch=8,16", "+dataset=sample,folder"], ["batch=8", "+dataset=folder"])
    'batch=8'
    """
    named_parameters = swept_over(arguments) - {"dataset", "dataset.name", "outputs"}
    overrides = [override.lstrip("+") for override in chosen]
    full_name = ",".join(override for override in overrides if override.partition("=")[0] in named_parameters)
    name = re.sub(r"[^\w.=,+-]+", "-", full_name)[:NAME_LENGTH]
    return name if name == full_name else f"{name}~{digest_text(full_name)[:8]}"


def _with_brackets(argument: str) -> str:
    name, _, value = argument.partition("=")
    bare = "," in value and not value.startswith(("[", "'", '"'))
    return f"{name}=[{value}]" if bare and name in list_names() else argument


def _is_value(argument: str) -> bool:
    return "=" in argument and not argument.startswith("-")


def _parse(arguments: Sequence[str]) -> list[Override]:
    try:
        return OverridesParser.create().parse_overrides([argument for argument in arguments if argument not in SWEEP])
    except HydraException as error:
        raise ConfigError(f"cannot read the command line, a list of name=value: {_unread(arguments, error)}") from error


def _refuse_commas(overrides: Sequence[Override]) -> None:
    for override in overrides:
        if override.is_sweep_override():
            name, _, value = str(override.input_line).partition("=")
            raise ConfigError(
                f"{name}: several values, {value}; to run each, add -m; a single value with a comma stands in quotes: "
                f"\"{name}='{value}'\""
            )


def _unread(arguments: Sequence[str], error: HydraException) -> str:
    """What to do about an argument that Hydra's grammar does not admit: put its value into quotes."""
    for argument in arguments:
        name, _, value = argument.partition("=")
        try:
            OverridesParser.create().parse_overrides([argument])
        except HydraException:
            if value and "'" not in value:
                return f"the value of {name} has characters that must be quoted; give \"{name}='{value}'\""
    return str(error)


def _compose(lines: list[str]) -> Config:
    try:
        with initialize_config_dir(version_base=HYDRA_BASE, config_dir=str(CONF)):
            return make_typed(compose("config", overrides=lines))
    except (HydraException, OmegaConfBaseException) as error:
        raise ConfigError(str(error).strip()) from error


def make_typed(composed: DictConfig) -> Config:
    """Make the typed configuration of Hydra's; raises `ConfigError`."""
    try:
        values = OmegaConf.to_container(composed, resolve=True, throw_on_missing=True)
    except OmegaConfBaseException as error:
        raise ConfigError(str(error).strip()) from error
    assert isinstance(values, dict)
    return make_config({str(name): value for name, value in values.items()})


def _check_name(override: Override) -> None:
    name = override.key_or_group
    if name == "hydra/launcher" and _values(override) != ["hydra/launcher=basic"]:
        raise ConfigError(
            f"{override.input_line}: jobs of a sweep run one after another in this process, which writes their table; "
            "the cluster spreads the work of each: cluster.workers=…, or cluster=slurm instead of submitit"
        )
    if name == "hydra" or name.startswith(("hydra.", "hydra/")):
        return
    choices, groups, allowed = group_choices(), parameter_groups(), allowed_names()
    whole_group = not override.is_sweep_override() and isinstance(override.value(), dict)
    if name in choices and not whole_group:
        for value in (line.partition("=")[2] for line in _values(override)):
            if value not in choices[name]:
                raise ConfigError(f"{name}={value}: no such choice; allowed: {', '.join(choices[name])}")
    elif name not in groups and name not in allowed:
        group, _, parameter = name.partition(".")
        within_group = [other for other in allowed if other.startswith(group + ".")] if parameter else []
        raise ConfigError(unknown_name(name, within_group or allowed))


def _check_dataset(overrides: Sequence[Override]) -> None:
    chosen = [str(override.input_line) for override in overrides if override.key_or_group == "dataset"]
    if len(chosen) > 1:
        raise ConfigError(f"{' '.join(chosen)}: give one data set")


def _values(override: Override) -> list[str]:
    """An override for each value of a sweep, or the one override that is no sweep."""
    if not override.is_sweep_override():
        return [str(override.input_line)]
    prefix = "+" if override.is_add() else ""
    return [f"{prefix}{override.key_or_group}={value}" for value in override.sweep_string_iterator()]

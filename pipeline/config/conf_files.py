"""Where `conf/` lies, what there is to choose from it, and the defaults that Hydra puts below its files.

`conf/` holds only what differs from the schema's defaults (tests/unit/test_conf_files.py). A wheel has it inside this
package, a checkout beside it.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any, get_origin, get_type_hints

from pipeline.config.schema import Config
from pipeline.errors import ConfigError
from riot.errors import needs_extra
from riot.parameters import ParameterGroup

with needs_extra("mine"):
    from hydra.core.config_store import ConfigStore

_SHIPPED = Path(__file__).resolve().parents[1] / "conf"
CONF = _SHIPPED if _SHIPPED.is_dir() else Path(__file__).resolve().parents[2] / "conf"
"""The folder of the configuration files."""


def parameter_groups() -> dict[str, type[ParameterGroup]]:
    """The groups of a configuration, such as ``trunks``, and the class of each, in the order of the schema."""
    return {name: kind for name, kind in get_type_hints(Config).items() if _is_group(kind)}


def allowed_names() -> list[str]:
    """Every parameter that a command line may set, as ``group.name``."""
    groups, names = parameter_groups(), []
    for field in dataclasses.fields(Config):
        group = groups.get(field.name)
        names += [f"{field.name}.{own.name}" for own in dataclasses.fields(group)] if group else [field.name]
    return names


def list_names() -> list[str]:
    """The parameters of `allowed_names` that are lists.

    >>> "select.classes" in list_names(), "select.top" in list_names()
    (True, False)
    """
    return [
        f"{name}.{own}"
        for name, group in parameter_groups().items()
        for own, kind in get_type_hints(group).items()
        if get_origin(kind) is tuple
    ]


def group_choices() -> dict[str, list[str]]:
    """Groups that have files to choose from in `conf/`, and the names of these files.

    Raises `ConfigError` if the folder is missing.
    """
    if not (CONF / "config.yaml").is_file():
        raise ConfigError(f"{CONF}: the configuration files are missing; install the project again")
    return {
        folder.name: sorted(file.stem for file in folder.glob("*.yaml"))
        for folder in sorted(CONF.iterdir())
        if folder.is_dir()
    }


def plain_defaults(group: type[ParameterGroup] = Config) -> dict[str, Any]:
    """The defaults of a group as plain values, which YAML can write.

    >>> plain_defaults()["select"]["top"]
    100
    """
    kinds = get_type_hints(group)
    return {
        field.name: plain_defaults(kinds[field.name]) if _is_group(kinds[field.name]) else _plain(field.default)
        for field in dataclasses.fields(group)
    }


def _is_group(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, ParameterGroup)


def _plain(default: Any) -> Any:
    if isinstance(default, tuple):
        return list(default)
    return str(default) if isinstance(default, Path) else default


# conf/config.yaml names this node in front of itself.
ConfigStore.instance().store(name="schema", node=plain_defaults())

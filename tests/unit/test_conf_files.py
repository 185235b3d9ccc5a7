"""The files of `conf/` hold what differs from the schema, in its words, and nothing else."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from omegaconf import OmegaConf

from pipeline.config.command_line import check_command, complete
from pipeline.config.conf_files import CONF, group_choices, parameter_groups, plain_defaults
from pipeline.config.schema import Config
from pipeline.datasets.collection import DatasetConfig

FILES = sorted(CONF.rglob("*.yaml"))


def named(path: Path) -> str:
    return str(path.relative_to(CONF))


def written(path: Path) -> dict[str, Any]:
    values = OmegaConf.to_container(OmegaConf.load(path))
    assert isinstance(values, dict)
    return {str(name): value for name, value in values.items() if name not in ("defaults", "hydra")}


@pytest.mark.parametrize("path", FILES, ids=named)
def test_every_name_is_in_the_schema_and_no_value_repeats_a_default(path: Path) -> None:
    inside = path.parent != CONF
    defaults = plain_defaults()[path.parent.name] if inside else plain_defaults()
    values = written(path)
    assert values.keys() <= defaults.keys()
    assert [name for name, value in values.items() if value == defaults[name]] == []


@pytest.mark.parametrize("path", FILES, ids=named)
def test_every_file_says_what_it_is_for(path: Path) -> None:
    assert path.read_text(encoding="utf-8").startswith("# ")


def test_the_defaults_of_a_run_are_those_of_the_schema() -> None:
    assert check_command(complete([])) == Config(dataset=DatasetConfig())


def test_folders_are_groups_of_the_schema() -> None:
    assert group_choices().keys() <= parameter_groups().keys()


def test_a_whole_group_is_given_by_names_and_values() -> None:
    trunks = check_command(complete(["trunks={tau_s: 0.2, tau_c: 0.4}"])).trunks
    assert (trunks.tau_s, trunks.tau_c, trunks.spacing) == (0.2, 0.4, 15.0)

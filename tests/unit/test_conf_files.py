"""The files of `conf/` hold what differs from the schema, in its words, and nothing else."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from omegaconf import OmegaConf

from pipeline.config.command_line import check_command, complete
from pipeline.config.conf_files import CONF, group_choices, parameter_groups, plain_defaults
from pipeline.config.schema import BendConfig, Config
from pipeline.config.selection import SelectConfig
from pipeline.datasets.collection import DatasetConfig
from pipeline.datasets.sample import definitions
from pipeline.plan.sources import ROOT

FILES = sorted(CONF.rglob("*.yaml"))


def named(path: Path) -> str:
    return str(path.relative_to(CONF))


def written(path: Path) -> dict[str, Any]:
    values = OmegaConf.to_container(OmegaConf.load(path))
    assert isinstance(values, dict)
    return {str(name): value for name, value in values.items() if name not in ("defaults", "hydra")}


@pytest.mark.parametrize("path", FILES, ids=named)
def test_every_name_is_in_the_schema_and_no_value_repeats_a_default(path: Path) -> None:
    is_global = "@package _global_" in path.read_text(encoding="utf-8")
    inside = path.parent != CONF and not is_global
    defaults = plain_defaults()[path.parent.name] if inside else plain_defaults()
    values = written(path)
    assert values.keys() <= defaults.keys()
    own = {name: (value, defaults[name]) for name, value in values.items()}
    for name in [name for name, (value, _) in own.items() if isinstance(value, dict)]:
        group, group_defaults = own.pop(name)
        assert group.keys() <= group_defaults.keys()
        own |= {f"{name}.{inner}": (group[inner], group_defaults[inner]) for inner in group}
    assert [name for name, (value, default) in own.items() if value == default] == []


@pytest.mark.parametrize("path", FILES, ids=named)
def test_every_file_says_what_it_is_for(path: Path) -> None:
    assert path.read_text(encoding="utf-8").startswith("# ")


def test_the_defaults_of_a_run_are_those_of_the_schema_but_for_the_haste_of_the_sample() -> None:
    sample = check_command(complete([]))
    assert replace(sample, select=SelectConfig(), bend=BendConfig()) == Config(dataset=DatasetConfig())
    assert sample.bend.method == BendConfig().method and sample.bend.steps < BendConfig().steps
    assert sample.select.top < SelectConfig().top
    assert check_command(complete(["+dataset=folder", "dataset.root=pictures"])).select == SelectConfig()


def test_a_value_of_the_command_line_is_stronger_than_the_sample_s() -> None:
    sample = check_command(complete([])).select
    for name, value in {"policy": "paper", "top": 100, "per_shape": 78, "breadth": 88, "pool": 9, "flat": True}.items():
        for line in ([f"select.{name}={value}"], [f"select.{name}={value}", "+dataset=sample"]):
            assert check_command(complete(line)).select == replace(sample, **{name: value})
    assert check_command(complete(["select=paper"])).select == replace(sample, policy="paper")
    assert check_command(complete(["select=paper", "select.top=100"])).select.top == 100


def test_dvc_mines_what_the_sample_has() -> None:
    values = OmegaConf.to_container(OmegaConf.load(ROOT / "params.yaml"))
    assert isinstance(values, dict) and values["dataset"] == "sample"
    assert values["limit"] == len(definitions()) and values["top"] == check_command(complete([])).select.top


def test_folders_are_groups_of_the_schema() -> None:
    assert group_choices().keys() <= parameter_groups().keys()


def test_a_whole_group_is_given_by_names_and_values() -> None:
    trunks = check_command(complete(["trunks={tau_s: 0.2, tau_c: 0.4}"])).trunks
    assert (trunks.tau_s, trunks.tau_c, trunks.spacing) == (0.2, 0.4, 15.0)

"""Configuration: whatever is wrong is named, with what is allowed, before any work."""

from __future__ import annotations

import dataclasses
from dataclasses import is_dataclass
from pathlib import Path
from typing import get_type_hints

import pytest

from pipeline.config.build import make_config
from pipeline.config.cluster import ClusterConfig
from pipeline.config.command_line import check_command, complete, sweep_point, sweep_values, swept_over
from pipeline.config.conf_files import allowed_names, group_choices
from pipeline.config.schema import Config
from pipeline.config.selection import SelectConfig
from pipeline.datasets.collection import DatasetConfig
from pipeline.errors import ConfigError
from riot.parameters import ParameterGroup
from riot.parameters.field import describe

SAMPLE = {"name": "sample", "kind": "sample"}


def check(*arguments: str) -> Config:
    return check_command(complete(arguments))


NEEDED = {"external": "cluster.address=tcp://host:1", "ssh": "cluster.hosts=a,b", "kubernetes": "cluster.image=riot"}


@pytest.mark.parametrize("kind", ["local", "sync", "external", "slurm", "ssh", "kubernetes"])
def test_every_cluster_has_a_file(kind: str) -> None:
    arguments = [f"cluster={kind}", *filter(None, [NEEDED.get(kind)])]
    assert check(*arguments).cluster.kind == kind
    assert set(group_choices()["cluster"]) == {"local", "sync", "external", "slurm", "ssh", "kubernetes"}


@pytest.mark.parametrize("policy", ["paper", "global"])
def test_every_policy_has_a_file(policy: str) -> None:
    assert check("+dataset=folder", "dataset.root=pictures", f"select={policy}").select == SelectConfig(policy=policy)  # type: ignore[arg-type]


def test_every_parameter_can_be_set_alone() -> None:
    config = check("trunks.tau_s=0.07", "select.top=5", "crs.lines=64", "cluster.workers=2", "batch=8", "outputs=here")
    assert config.trunks.tau_s == 0.07 and config.select.top == 5 and config.crs.lines == 64
    assert config.cluster == ClusterConfig(workers=2) and config.batch == 8 and config.outputs == Path("here")
    assert {"trunks.tau_s", "shape.spacing", "dataset.root", "batch"} <= set(allowed_names())


def test_data_sets_and_flags() -> None:
    assert check("+dataset=mpeg7", "dataset.root=/x").dataset == DatasetConfig("mpeg7", "mpeg7", "/x")
    assert check("dataset=folder", "dataset.root=/x").dataset.kind == "folder"
    assert check("--plan").plan and check("--explain").explain
    assert not check().plan


@pytest.mark.parametrize(
    ("argument", "words"),
    [
        ("trunks.tau=0.1", ["trunks.tau:", "Did you mean trunks.tau_s", "trunks.max_arc"]),
        ("trunk.tau_s=0.1", ["trunk.tau_s", "trunks.tau_s"]),
        ("speed=1", ["speed", "Allowed", "batch"]),
        ("+trunks.new=1", ["trunks.new", "Allowed"]),
        ("trunks.tau_s=abc", ["trunks.tau_s", "number", "'abc'"]),
        ("trunks.tau_s=null", ["trunks.tau_s", "number"]),
        ("trunks.tau_s=true", ["trunks.tau_s", "number"]),
        ("trunks.max_vertices=3.5", ["trunks.max_vertices", "whole number"]),
        ("trunks.max_vertices=2", ["trunks.max_vertices", "3"]),
        ("trunks.tau_s=-1", ["trunks.tau_s", "greater than 0"]),
        ("trunks.tau_s=nan", ["trunks.tau_s", "finite"]),
        ("trunks.min_inside=1.5", ["trunks.min_inside", "0 to 1"]),
        ("select.policy=best", ["select.policy", "varied, global, paper"]),
        ("select=best", ["select=best", "global, paper, varied"]),
        ("select.top=0", ["select.top: must be 1 or more, got 0"]),
        ("hydra/launcher=joblib", ["hydra/launcher=joblib", "one after another", "cluster.workers"]),
        ("hydra/launcher=submitit_slurm", ["one after another", "cluster=slurm"]),
        ("cluster=big", ["cluster=big", "external, kubernetes, local, slurm, ssh, sync"]),
        ("cluster=external", ["cluster.address", "tcp://"]),
        ("cluster.workers=0", ["cluster.workers", "1 or more"]),
        ("+dataset=mpeg", ["dataset=mpeg", "mpeg7", "sample"]),
        ("dataset.limit=0", ["dataset.limit: ", "1 or more"]),
        ("dataset.name=a/b", ["dataset.name: ", "folder"]),
        ("batch=0", ["batch", "1 or more"]),
        ("outputs=null", ["outputs", "path"]),
        ("outputs=", ["outputs", "path"]),
        ("trunks=null", ["trunks"]),
        ("nonsense", ["nonsense", "name=value"]),
        ("dataset.root=here", ["dataset.root", "sample", "+dataset=folder"]),
        ("+dataset.root=here", ["dataset.root", "sample", "+dataset=folder"]),
        ("reversibility.waist_low=2", ["reversibility.waist_low", "waist_high"]),
        ("store=s3://", ["store: 's3://' is no URL", "s3://bucket/prefix"]),
        ("store=null", ["store: expected a path or a URL, got None"]),
        ("cluster.options=[1]", ["cluster.options[0]: expected text, got 1"]),
        ("trunks=3", ["trunks: expected a group of parameters, got 3"]),
        ("qcrs.sigma_e=0", ["qcrs.sigma_e: must be greater than 0 D_c, or null, got 0"]),
    ],
)
def test_mistakes_are_named_with_what_is_allowed(argument: str, words: list[str]) -> None:
    with pytest.raises(ConfigError) as caught:
        check(argument)
    message = str(caught.value)
    assert all(word in message for word in words), message


@pytest.mark.parametrize("group", [Config, *(kind for kind in get_type_hints(Config).values() if is_dataclass(kind))])
def test_every_parameter_is_declared_with_its_meaning_and_source(group: type[ParameterGroup]) -> None:
    for field in dataclasses.fields(group):
        declared = describe(field)
        if declared is None:
            assert group is Config and is_dataclass(get_type_hints(Config)[field.name])
        else:
            assert declared.meaning.endswith(".") and declared.source and field.default is not dataclasses.MISSING
            is_number = isinstance(field.default, int | float) and not isinstance(field.default, bool)
            assert not is_number or declared.range, field.name


def test_one_data_set_with_its_own_parameters() -> None:
    with pytest.raises(ConfigError, match="one data set"):
        check("+dataset=sample", "+dataset=mpeg7")
    with pytest.raises(ConfigError, match=r"dataset\.animals: the data set mpeg7 has"):
        check("+dataset=mpeg7", "dataset.animals=here")
    with pytest.raises(ConfigError, match="expected a folder"):
        check("+dataset=folder", "dataset.root=")


def test_all_values_of_a_sweep_are_checked_before_its_first_run() -> None:
    assert check("-m", "trunks.tau_s=0.1,0.07").trunks.tau_s == 0.1
    for wrong in ("trunks.tau_s=x,0.07", "trunks.tau_s=0.1,x", "+dataset=sample,mine", "select=global,best"):
        with pytest.raises(ConfigError):
            check("-m", "trunks.tau_c=0.3,0.2", wrong)


def test_points_of_a_sweep_have_names_of_their_own() -> None:
    arguments = ["-m", "trunks.tau_s=0.1,0.07", "+dataset=sample,folder", "batch=8", "select=paper,global"]
    chosen = ["trunks.tau_s=0.07", "+dataset=folder", "batch=8", "select=paper"]
    assert sweep_point(arguments, chosen) == "trunks.tau_s=0.07,select=paper"
    roots = ["dataset.root=/c d,-c d,-c-d"]
    named = {sweep_point(roots, [one]) for one in ("dataset.root=/c d", "dataset.root=-c d", "dataset.root=-c-d")}
    assert len(named) == 3 and "dataset.root=-c-d" in named and not any("/" in name for name in named)
    long = {sweep_point(["batch=1,2"], [f"batch={'1' * 300}{end}"]) for end in "12"}
    assert len(long) == 2 and max(map(len, long)) < 255
    assert sweep_point(["outputs=a,b"], ["outputs=a"]) == ""


def test_values_of_a_sweep_have_types() -> None:
    arguments = [
        "-m",
        "trunks.tau_s=0.1,2",
        "+dataset=sample,folder",
        "batch=8",
        "qcrs.sigma_e=null,1",
        "plan=true,false",
    ]
    chosen = ["trunks.tau_s=2", "+dataset=folder", "batch=8", "qcrs.sigma_e=null", "plan=true"]
    found = {"trunks.tau_s": 2, "dataset": "folder", "qcrs.sigma_e": None, "plan": True}
    assert sweep_values(arguments, chosen) == found and swept_over(arguments) == found.keys()


def test_options_of_a_cluster_are_a_list_of_text() -> None:
    given = check("cluster=slurm", "cluster.options=['--qos=long',--exclusive]")
    assert given.cluster.options == ("--qos=long", "--exclusive")
    for wrong in ("cluster.options=long", "cluster.options=[1]", "cluster.jobs=0"):
        with pytest.raises(ConfigError, match=wrong.partition("=")[0]):
            check("cluster=slurm", wrong)


def test_plain_values_are_enough() -> None:
    config = make_config({"dataset": SAMPLE, "select": {"top": 3}})
    assert config.select.top == 3 and dataclasses.is_dataclass(config.trunks)
    with pytest.raises(ConfigError, match="dataset"):
        make_config({})
    with pytest.raises(ConfigError, match="group"):
        make_config({"dataset": SAMPLE, "select": 3})


@pytest.mark.parametrize("path", ["/tmp/a=b", "/tmp/a,b", "/tmp/a (b)", "~/pics"])
def test_a_path_that_needs_quotes_is_told_so(path: str) -> None:
    quoted = f"dataset.root='{path}'"
    with pytest.raises(ConfigError) as caught:
        check_command(complete(["+dataset=folder", f"dataset.root={path}"]))
    assert f'"{quoted}"' in str(caught.value)
    assert check_command(complete(["+dataset=folder", quoted])).dataset.root == path

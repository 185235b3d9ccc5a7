"""`python -m pipeline.run --help` and the guide list every parameter with what its declaration says of it."""

from __future__ import annotations

import dataclasses
import re

import pytest
from omegaconf import OmegaConf

from pipeline import exit_codes
from pipeline.config.conf_files import allowed_names, group_choices, parameter_groups, plain_defaults
from pipeline.config.parameter_table import parameter_table, sections
from pipeline.run import main
from riot.parameters.field import describe

WIDTH = 80


@pytest.fixture(params=["--help", "-h"])
def printed(request: pytest.FixtureRequest, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.setenv("COLUMNS", str(WIDTH))
    assert main(["trunks.tau_s=wrong", request.param]) == exit_codes.CLEAN
    return capsys.readouterr().out


def test_help_lists_every_parameter_with_its_default_within_its_width(printed: str) -> None:
    assert re.findall(r"^  ([\w.]+)=\S*\s+\(", printed, flags=re.MULTILINE) == [
        row.name for section in sections() for row in section.rows
    ]
    assert max(map(len, printed.splitlines())) <= WIDTH
    text = " ".join(printed.split())
    for name, group in parameter_groups().items():
        for field in dataclasses.fields(group):
            declared = describe(field)
            assert declared is not None and f"{name}.{field.name}=" in text
            assert declared.meaning in text and declared.unit in text and declared.source in text


def test_help_lists_choices_and_exit_codes(printed: str) -> None:
    for group, names in group_choices().items():
        assert re.search(rf"^  {group}= +{re.escape(' | '.join(names))}$", printed, flags=re.MULTILINE)
    codes = {value for name, value in vars(exit_codes).items() if name.isupper() and isinstance(value, int)}
    assert exit_codes.MEANINGS.keys() == codes
    for code, meaning in exit_codes.MEANINGS.items():
        assert re.search(rf"^  {code} +{re.escape(meaning[:40])}", printed, flags=re.MULTILINE)


def test_the_sections_have_every_name_that_a_command_line_may_set() -> None:
    assert {row.name for section in sections() for row in section.rows} == set(allowed_names())


def test_the_table_has_a_row_for_every_parameter_and_no_broken_cell() -> None:
    rows = [line for line in parameter_table().splitlines() if line.startswith("| `")]
    assert [re.match(r"\| `([\w.]+)` ", line)[1] for line in rows] == [  # type: ignore[index]
        row.name for section in sections() for row in section.rows
    ]
    assert {line.count("|") for line in rows} == {6}


def test_flags_of_hydra_reach_it(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--hydra-help"]) == exit_codes.CLEAN and "Hydra" in capsys.readouterr().out
    for arguments in (
        ["+dataset=folder", "select=paper", "--cfg", "job", "--package", "select"],
        ["--cfg", "job", "+dataset=folder", "select=paper"],
    ):
        assert main(arguments) == exit_codes.CLEAN
        values = OmegaConf.to_container(OmegaConf.create(capsys.readouterr().out))
        assert isinstance(values, dict)
        assert values.get("select", values) == {**plain_defaults()["select"], "policy": "paper"}

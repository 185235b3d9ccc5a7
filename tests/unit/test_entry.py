"""The program ends quietly when Ctrl-C comes while its modules load."""

from __future__ import annotations

import importlib.abc
import sys
from collections.abc import Sequence
from types import ModuleType

import pytest

from pipeline.entry import main
from pipeline.exit_codes import INTERRUPTED


class Interrupts(importlib.abc.MetaPathFinder):
    """Stands for a key that is pressed while a module is looked for."""

    def find_spec(self, name: str, path: Sequence[str] | None, target: ModuleType | None = None) -> None:
        if name == "pipeline.cli.main":
            raise KeyboardInterrupt


def test_ctrl_c_while_modules_load_is_an_exit_code(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, "pipeline.cli.main", raising=False)
    monkeypatch.setattr(sys, "meta_path", [Interrupts(), *sys.meta_path])
    assert main() == INTERRUPTED


def test_else_it_is_the_program(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(sys, "argv", ["riot", "--version"])
    assert main() == 0
    assert capsys.readouterr().out.startswith("riot ")

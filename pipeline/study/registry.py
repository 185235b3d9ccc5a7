"""The studies by name. What a study is lies in the module of its name, which is loaded when it is asked for."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from types import MappingProxyType
from typing import Any

from pipeline.study.findings import Findings
from pipeline.study.finished import Finished
from pipeline.study.names import MEANINGS

Say = Callable[[str], None]


@dataclass(frozen=True)
class Study:
    """A study: its name, and what it tells in a line.

    Its module has ``Parameters``, a dataclass with defaults, and ``study``, which makes its findings.
    """

    name: str
    meaning: str

    @property
    def parameters(self) -> type:
        """What it can be told."""
        return self._module().Parameters  # type: ignore[no-any-return]

    def run(self, finished: Finished, parameters: Any, say: Say) -> Findings:
        """Make its findings of a run."""
        return self._module().study(finished, parameters, say)  # type: ignore[no-any-return]

    def _module(self) -> Any:
        return import_module(f"pipeline.study.{self.name}")


STUDIES: Mapping[str, Study] = MappingProxyType({name: Study(name, meaning) for name, meaning in MEANINGS.items()})

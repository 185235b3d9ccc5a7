"""The studies by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from pipeline.study import consistency, distributions, groundtruth, parameters, quiz, sigmas, timing
from pipeline.study.findings import Findings
from pipeline.study.finished import Finished

Say = Callable[[str], None]


@dataclass(frozen=True)
class Study:
    """A study: what it tells in a line, its parameters, a dataclass with defaults, and what makes its findings."""

    meaning: str
    parameters: type
    run: Callable[[Finished, Any, Say], Findings]


STUDIES: Mapping[str, Study] = MappingProxyType(
    {
        "consistency": Study("how far QCRS orders pairs as CRS does", consistency.Parameters, consistency.study),
        "distributions": Study("how scores are spread, by class", distributions.Parameters, distributions.study),
        "groundtruth": Study("whether hidden exact pairs are found", groundtruth.Parameters, groundtruth.study),
        "parameters": Study("what the method's parameters do", parameters.Parameters, parameters.study),
        "quiz": Study("pairs to judge, as the paper's people did", quiz.Parameters, quiz.study),
        "sigmas": Study("what a greater σ_A of QCRS gains and costs", sigmas.Parameters, sigmas.study),
        "timing": Study("what each step costs, beside the paper", timing.Parameters, timing.study),
    }
)

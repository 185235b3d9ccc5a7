"""The effect of one parameter of candidate trunks: how many true trunks are lost, and the CPU time. Ours."""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeline.study.hidden import NEAR, Hidden, failed_test, nearest
from riot.geometry.shape import Shape
from riot.parameters import TrunkParameters
from riot.scores.trunks import full_trunks
from riot.types import FloatArray, IntArray
from riot.units import L_C


@dataclass(frozen=True, eq=False)
class TrunkOutcome:
    """What one value of one parameter gives.

    Parameters
    ----------
    parameter : str
        A field of `riot.parameters.TrunkParameters`.
    value : float
    default : bool
        Whether it is the run's own.
    error : (h,) float64
        Of every hidden shape how far the nearest candidate trunk is from the true one, at its worst corner, in units of
        ``L_c``; inf if there is none of that many corners.
    lost : Counter
        The tests after which nothing near the true trunk is left, by how many hidden shapes they cost.
    trunks : (s,) int64
        Candidate trunks of each shape of the sample.
    seconds : float
        CPU time of the candidate trunks of one shape, the mean over both. It varies from run to run.
    """

    parameter: str
    value: float
    default: bool
    error: FloatArray
    lost: Counter[str]
    trunks: IntArray
    seconds: float

    @property
    def found(self) -> int:
        """How many hidden shapes have a candidate trunk near the true one."""
        return int((self.error <= NEAR / L_C).sum())

    @property
    def mean_error(self) -> float:
        """Mean ``error`` of the hidden shapes that have one; nan without any."""
        known = self.error[np.isfinite(self.error)]
        return float(known.mean()) if len(known) else math.nan


def vary(
    hidden: Sequence[Hidden],
    shapes: Sequence[Shape],
    default: TrunkParameters,
    values: Mapping[str, Sequence[float]],
    say: Callable[[str], None],
) -> Iterator[TrunkOutcome]:
    """Outcomes by parameter and rising value, the default's among them; all other parameters are the default's."""
    # The default is one outcome for all parameters, so that what they are compared with is the same.
    say("candidate trunks by the run's own parameters …")
    common = _outcome(hidden, shapes, default)
    for name, chosen in values.items():
        run_value = float(getattr(default, name))
        for value in sorted({*chosen, run_value}):
            if value == run_value:
                yield replace(common, parameter=name, value=value, default=True)
            else:
                say(f"candidate trunks with {name}={value:g} …")
                changed = replace(default, **{name: value})  # type: ignore[arg-type]  # only floats are varied
                yield replace(_outcome(hidden, shapes, changed), parameter=name, value=value)


def _outcome(hidden: Sequence[Hidden], shapes: Sequence[Shape], parameters: TrunkParameters) -> TrunkOutcome:
    begun = time.process_time()
    hidden_trunks = [full_trunks(hidden_shape.shape, parameters) for hidden_shape in hidden]
    others = [full_trunks(shape, parameters) for shape in shapes]
    seconds = (time.process_time() - begun) / (len(hidden) + len(shapes))
    error = (
        np.array([nearest(hidden_shape, trunks) for hidden_shape, trunks in zip(hidden, hidden_trunks, strict=True)])
        / L_C
    )
    lost = Counter(
        failed_test(hidden_shape, trunks, False, parameters)
        for hidden_shape, trunks in zip(hidden, hidden_trunks, strict=True)
    )
    del lost[""]
    return TrunkOutcome("", math.nan, False, error, lost, np.array([len(trunks) for trunks in others]), seconds)

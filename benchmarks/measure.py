"""Timing: CPU time of items, and where it goes."""

from __future__ import annotations

import cProfile
import pstats
import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, TypeVar

import numpy as np

from riot.errors import RiotError

T = TypeVar("T")
R = TypeVar("R")

NAMED_FUNCTIONS = 3
"""So many parts are named of what a step spends its time on."""


@dataclass(frozen=True)
class Timed(Generic[R]):
    """Results, None where the library refused, and the CPU milliseconds of each item; a refusal is an item too."""

    results: list[R | None]
    ms: list[float]

    @property
    def good(self) -> list[R]:
        """The results without the refused."""
        return [result for result in self.results if result is not None]

    @property
    def mean(self) -> float:
        """Mean of the items."""
        return float(np.mean(self.ms)) if self.ms else float("nan")


def time_items(function: Callable[[T], R], items: Sequence[T], repeats: int = 1) -> Timed[R]:
    """Call ``function`` for every item; of several rounds over all items each item's least time counts."""
    results: list[R | None] = [None] * len(items)
    least = [float("inf")] * len(items)
    for _ in range(repeats):
        for k, item in enumerate(items):
            start = time.process_time()
            try:
                results[k] = function(item)
            except RiotError:
                results[k] = None
            least[k] = min(least[k], 1e3 * (time.process_time() - start))
    return Timed(results, least)


def least_seconds(function: Callable[[], object], repeats: int = 5) -> float:
    """CPU seconds of one call, the least of several."""
    least = float("inf")
    for _ in range(repeats):
        start = time.process_time()
        function()
        least = min(least, time.process_time() - start)
    return least


def time_shares(function: Callable[[T], object], items: Sequence[T]) -> str:
    """Which functions the time is spent in, with their shares, under a profiler.

    The library's functions by module and name, everything else by package; a compiled kernel counts with the function
    that calls it.
    """
    if not items:
        return ""
    profile = cProfile.Profile()
    profile.enable()
    for item in items:
        try:
            function(item)
        except RiotError:
            continue
    profile.disable()
    spent: Counter[str] = Counter()
    for (file, _, name), (_, _, own, _, _) in pstats.Stats(profile).stats.items():  # type: ignore[attr-defined]
        spent[_module_of(file, name)] += own
    total = sum(spent.values())
    return ", ".join(f"{module} {100 * own / total:.0f} %" for module, own in spent.most_common(NAMED_FUNCTIONS))


def _module_of(file: str, name: str) -> str:
    where = Path(file)
    if "riot" in where.parts:
        inside = where.parts[len(where.parts) - 1 - where.parts[::-1].index("riot") + 1 :]
        return f"{'.'.join(inside).removesuffix('.py')}:{name}"
    if "site-packages" in where.parts:
        return where.parts[where.parts.index("site-packages") + 1]
    return "Python and C builtins"

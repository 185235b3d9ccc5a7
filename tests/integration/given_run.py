"""A finished run that is given: tables written by hand, shapes in memory, for studies under test."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, cast

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from pipeline.config.build import make_config
from pipeline.match.search import MinedRun
from pipeline.study.finished import StudiedRun
from riot.geometry.shape import Shape
from riot.scores.reversibility import reversibility


@dataclass(frozen=True, eq=False)
class GivenRun(StudiedRun):
    """A finished run whose shapes need no store."""

    given: tuple[Shape, ...]

    @cached_property
    def shapes(self) -> list[Shape]:
        return list(self.given)


def given_run(folder: Path, shapes: Sequence[Shape], classes: int) -> GivenRun:
    """A run of these shapes, by turns of so many classes, with the tables of shapes and of reversibility."""
    count = len(shapes)
    names = tuple(f"name<{number}>" for number in range(count))
    kinds = tuple(f"class&{number % classes}" for number in range(count))
    config = make_config({"dataset": {"name": "sample", "kind": "sample"}})
    store = cast(Any, None)  # it is asked for shapes alone
    scores = [reversibility(shape) for shape in shapes]
    columns = {name: [getattr(score, name) for score in scores] for name in ("score", "s1", "s2")}
    pq.write_table(pa.table(columns), folder / "reversibility.parquet")
    pq.write_table(pa.table({"trunks": [9] * count}), folder / "shapes.parquet")
    return GivenRun(MinedRun(folder, "given", config, store, names, kinds, names, (), np.arange(count)), tuple(shapes))

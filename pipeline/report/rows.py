"""Rows of a run's tables as the pages show them: typed, null = nan, None, or empty. Ours."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import PurePosixPath
from typing import Any, TypeVar

RowType = TypeVar("RowType")

NULLS: Mapping[str, Any] = {"float": math.nan, "int": 0, "str": "", "tuple[str, ...]": ()}
"""What stands for null, by the type of a column; None for all others."""

NAMES: Mapping[str, str] = {"name_p": "name_i", "name_q": "name_j", "class_p": "class_i", "class_q": "class_j"}
"""Columns that the tables name by the shapes' numbers, by the name that they have here."""


@dataclass(frozen=True)
class TransformRow:
    """One row of `transforms`; `pipeline.tables.schemas.SCHEMAS` tells what its columns mean; nan = null."""

    rank: int
    name_p: str
    name_q: str
    class_p: str
    class_q: str
    status: str
    reason: str
    message: str
    file: str
    qcrs: float
    crs: float
    s_edge: float
    s_angle: float
    s_area: float
    n: int
    iou: float
    iou_p: float
    iou_q: float
    bound_p: float
    bound_q: float
    hausdorff_p: float
    hausdorff_q: float
    mean_distance_p: float
    mean_distance_q: float
    change_ratio: float
    bending_p: float
    bending_q: float
    direction_p: float
    direction_q: float
    cldice: float
    centreline_recall_p: float
    centreline_recall_q: float
    overlap_p: float
    overlap_q: float
    gap_p: float
    gap_q: float
    hinge_p: float
    hinge_q: float
    margin: float
    margin_p: float
    margin_q: float
    other_p: str
    other_q: str
    surprise: float
    input_iou: float
    rms_strain: float
    rms_strain_p: float
    rms_strain_q: float
    max_strain_p: float
    max_strain_q: float
    swings_flat: bool | None
    """None = not planned."""

    @property
    def classes(self) -> tuple[str, ...]:
        """The classes of its shapes, each once, without those of shapes that have none."""
        return tuple(dict.fromkeys(name for name in (self.class_p, self.class_q) if name))

    @property
    def named_sides(self) -> tuple[tuple[str, str], tuple[str, str]]:
        """Name and class of P, and of Q."""
        return (self.name_p, self.class_p), (self.name_q, self.class_q)

    @property
    def stem(self) -> str:
        """Name of its file, without folder and suffix."""
        return PurePosixPath(self.file).stem

    @property
    def page(self) -> str:
        """File name of its own page in the gallery's folder."""
        return f"{self.stem}.html"

    @property
    def thumb(self) -> str:
        """File name of its small picture there."""
        return f"{self.stem}.svg"

    @property
    def swing(self) -> str:
        """File name of its animation there; empty if no motion is planned."""
        return "" if self.approximate else f"{self.stem}.swing.svg"

    @property
    def preview(self) -> str:
        """File name of the picture that stands for its page where a link to it is shown."""
        return f"{self.stem}.png"

    @property
    def hausdorff(self) -> float:
        """Hausdorff distance of the worse shape."""
        return max(self.hausdorff_p, self.hausdorff_q)

    @property
    def approximate(self) -> bool:
        """Whether it is not exact: made by the paper's method."""
        return self.status == "approximate"

    @property
    def area_residual(self) -> float:
        """The greatest of the certificate's areas."""
        return _greatest(self.overlap_p, self.overlap_q, self.gap_p, self.gap_q)

    @property
    def hinge_residual(self) -> float:
        """The greatest distance at a hinge."""
        return _greatest(self.hinge_p, self.hinge_q)


@dataclass(frozen=True)
class PuzzleRow:
    """One row of the table `fabrications`."""

    rank: int
    name_p: str
    name_q: str
    status: str
    message: str
    folder: str
    size: float
    thickness: float
    changes: tuple[str, ...]
    parts: float
    volume: float
    least_wall: float
    proven_gap: float
    overlap: float
    pin_hinges: int | None
    telescopic_hinges: int | None
    warnings: tuple[str, ...]

    @property
    def notes(self) -> tuple[str, ...]:
        """What its maker should read: why it is refused, what was changed, and warnings."""
        notes = (self.message, *(f"changed {words}" for words in self.changes), *self.warnings)
        return tuple(words for words in notes if words)


@dataclass(frozen=True)
class ErrorRow:
    """One row of the table `errors`."""

    item: str
    stage: str
    type: str
    reason: str
    message: str
    attempts: int


@dataclass(frozen=True)
class TimingRow:
    """One row of the table `timings`; times in seconds, memory in MiB."""

    stage: str
    items: int
    cached: int
    computed: int
    failed: int
    seconds: float
    cpu_seconds: float
    stored_seconds: float
    peak_mb: float


def typed_row(kind: type[RowType], row: Mapping[str, Any]) -> RowType:
    """A row of a table as the dataclass ``kind``, whose fields are columns; columns that are not there are null.

    >>> typed_row(ErrorRow, {"item": "a.png", "attempts": 2}).stage
    ''
    """
    values: dict[str, Any] = {}
    for field in fields(kind):  # type: ignore[arg-type]
        value = row.get(NAMES.get(field.name, field.name))
        if value is None:
            value = NULLS.get(str(field.type))
        values[field.name] = tuple(value) if isinstance(value, list) else value
    return kind(**values)


def _greatest(*values: float) -> float:
    return max((abs(value) for value in values if math.isfinite(value)), default=math.nan)

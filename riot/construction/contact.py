"""Contact: whether each exterior piece keeps its trunk edge where the other shape's trunk is shared out (theory §8)."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from riot.construction.mesh import Mesh, mesh_convex
from riot.construction.partition import label_cells, require_contact
from riot.errors import ConstructionError
from riot.parameters import ConstructParameters
from riot.types import FloatArray, IntArray
from riot.units import L_C

if TYPE_CHECKING:
    from riot.construction.plan import ConstructionPlan


def require_plan_contact(plan: ConstructionPlan, spacing: float, allowed: float) -> None:
    """Raise ConstructionError if a piece would lose contact with its trunk edge; far cheaper than `dissect_plan`.

    ``spacing`` and ``allowed`` as `spacing` and `max_lost_contact` of `riot.parameters.ConstructParameters`.
    """
    _require(plan, spacing, lambda mesh, arcs, offsets: require_contact(mesh, arcs, offsets, allowed))


def require_plan_cells(plan: ConstructionPlan, parameters: ConstructParameters) -> None:
    """Raise ConstructionError if a piece would lose contact with its trunk edge, or fall apart: a tenth of the price of
    `dissect_plan`.

    >>> from riot.construction import alternatives
    >>> require_plan_cells(alternatives(house, kite)[0], ConstructParameters())
    """
    _require(plan, parameters.spacing, lambda mesh, arcs, offsets: label_cells(mesh, arcs, offsets, parameters))


def _require(plan: ConstructionPlan, spacing: float, check: Callable[[Mesh, FloatArray, IntArray], object]) -> None:
    for trunk, arcs, label in (
        (plan.trunk_q[::-1], backwards(plan.arcs_p, plan.offsets_p), "Q's trunk"),
        (plan.trunk_p, backwards(plan.arcs_q, plan.offsets_q), "P's trunk"),
    ):
        try:
            check(mesh_convex(trunk, L_C / spacing), *arcs)
        except ConstructionError as error:
            raise ConstructionError(error.reason, f"in {label}: {error}") from None


def backwards(arcs: FloatArray, offsets: IntArray) -> tuple[FloatArray, IntArray]:
    """The arcs in opposite order, each read backwards: what runs clockwise around a trunk then runs
    counter-clockwise."""
    total = offsets[-1]
    return np.ascontiguousarray(arcs[::-1]), (total - offsets[::-1]).astype(np.int64)

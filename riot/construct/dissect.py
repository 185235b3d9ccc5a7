"""The dissection of one trunk by the arcs swung into it: cells, their tree, the path around each cell (theory §8)."""

from __future__ import annotations

from riot.construct.mesh import mesh_convex
from riot.construct.partition import label_cells
from riot.construct.tree import cell_paths, dissection_tree
from riot.errors import ConstructionError
from riot.parameters import L_C, ConstructParameters
from riot.shape import FloatArray, IntArray


def dissect(
    trunk: FloatArray, arcs: tuple[FloatArray, IntArray], parameters: ConstructParameters, where: str
) -> list[FloatArray]:
    """Paths of the dissection tree, one per edge of a counter-clockwise trunk, from its corner k to corner k + 1.

    ``arcs`` run around the trunk counter-clockwise; arc 0 may belong to any edge, its first point tells which.
    ConstructionError with the reason, beginning with ``where``, if the partition fails.
    """
    spacing = L_C / parameters.spacing
    try:
        cells = label_cells(mesh_convex(trunk, spacing), *arcs, parameters)
        return cell_paths(cells, dissection_tree(cells, parameters.tolerance * spacing))
    except ConstructionError as error:
        raise ConstructionError(error.reason, f"in {where}: {error}") from None

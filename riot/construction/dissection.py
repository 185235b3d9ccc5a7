"""The dissection of one trunk by the arcs swung into it: cells, their tree, the path round each cell (theory §8)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from riot.construction.detail import Detailed, add_detail
from riot.construction.mesh import mesh_convex
from riot.construction.partition import label_cells
from riot.construction.tree import TreeArc, Walk, cell_walks, dissection_tree, joined
from riot.construction.tree_match import TreeMatch, match_tree
from riot.errors import ConstructionError
from riot.parameters import ConstructParameters, DetailParameters
from riot.types import FloatArray, IntArray
from riot.units import L_C


@dataclass(frozen=True, eq=False)
class Dissection:
    """A partitioned trunk, kept so that its arcs can be solved for again without a new partition.

    Parameters
    ----------
    trunk : (n, 2) float64
        Counter-clockwise.
    arcs : n arrays (s, 2) float64
        The swung arcs, arc k from corner k to corner k + 1.
    tree : tuple of TreeArc
        The middle lines of the partition.
    detail : DetailParameters
    """

    trunk: FloatArray
    arcs: tuple[FloatArray, ...]
    tree: tuple[TreeArc, ...]
    detail: DetailParameters

    @cached_property
    def walks(self) -> list[Walk]:
        """For every trunk edge the tree arcs from its corner to the next; see `riot.construction.tree.cell_walks`."""
        return cell_walks(len(self.trunk), self.tree)

    @cached_property
    def match(self) -> TreeMatch:
        """The tree's arcs matched with the swung arcs beside them."""
        return match_tree(self.tree, self.arcs, self.detail)

    @cached_property
    def detailed(self) -> Detailed:
        """The tree's arcs with the detail of the swung arcs."""
        return add_detail(self.plain_paths, self.arcs, self.match, self.detail)

    @cached_property
    def paths(self) -> list[FloatArray]:
        """(l, 2) for every trunk edge k the path of the tree from corner k to corner k + 1, with detail."""
        return self.detailed.paths

    @cached_property
    def plain_paths(self) -> list[FloatArray]:
        """The same along the middle lines of the partition."""
        return [joined([arc.points for arc in self.tree], walk) for walk in self.walks]


def dissect(
    trunk: FloatArray,
    arcs: tuple[FloatArray, IntArray],
    parameters: ConstructParameters,
    label: str,
    detail: DetailParameters | None = None,
) -> Dissection:
    """Partition a counter-clockwise trunk (n, 2); its `Dissection.paths` run around the cells (theory §8, ours).

    ``arcs`` (s, 2) with offsets (n + 1,) run around the trunk counter-clockwise; arc 0 may belong to any edge, its
    first point tells which. Raises ConstructionError with the reason if the partition fails; ``label`` says in its
    message which trunk that is.
    """
    spacing = L_C / parameters.spacing
    points, offsets = arcs
    try:
        cells = label_cells(mesh_convex(trunk, spacing), points, offsets, parameters)
        tree = tuple(dissection_tree(cells, parameters.tolerance * spacing))
        cell_walks(len(trunk), tree)
    except ConstructionError as error:
        raise ConstructionError(error.reason, f"in {label}: {error}") from None
    n = len(trunk)
    first = int(np.argmin(((points[offsets[:-1]] - trunk[0]) ** 2).sum(axis=1)))
    order = [(first + k) % n for k in range(n)]
    arcs_by_edge = []
    for k, i in enumerate(order):
        arc = np.array(points[offsets[i] : offsets[i + 1]])
        arc[0], arc[-1] = trunk[k], trunk[(k + 1) % n]
        arcs_by_edge.append(arc)
    return Dissection(np.array(trunk), tuple(arcs_by_edge), tree, detail or DetailParameters())

"""Cells of a trunk: every point goes to the exterior piece of smallest signed distance (theory §8, ours).

Overlaps are split along their middle line, gaps are shared out along theirs. Cells must be connected and keep their
trunk edge: what is cut off from its edge is flooded by its neighbours, and too much of that is a rejected
construction.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from riot.construction.mesh import Mesh
from riot.construction.tuning import CONTACT_SLACK, INWARD_SHARE
from riot.errors import ConstructionError
from riot.kernels.cells import Arcs, boxed, distances_beside, flood, lost_contact, nearest_pieces, rooted, weights
from riot.parameters import ConstructParameters
from riot.types import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Cells:
    """A labelled mesh.

    Parameters
    ----------
    labels : (k,) int64
        The cell of every mesh point.
    mixed : (m, 3) int64
        The mesh's triangles in which cells meet.
    distances : (k, n) float64
        Signed distance of every mesh point to every piece, negative inside; NaN where nothing has asked for it. Known
        at the points of ``mixed`` for the pieces of the cells that meet there.
    """

    mesh: Mesh
    labels: IntArray
    mixed: IntArray
    distances: FloatArray


def label_cells(mesh: Mesh, arcs: FloatArray, offsets: IntArray, parameters: ConstructParameters) -> Cells:
    """Label every mesh point with its cell (theory §8, ours).

    Raises ConstructionError if a cell falls apart or loses its edge by more than the parameters allow.

    ``arcs`` (s, 2) with ``offsets`` (n + 1,) are the pieces' arcs, counter-clockwise around the trunk. Arc 0 may belong
    to any edge: its first point tells which.
    """
    inside, pieces, distances = require_contact(mesh, arcs, offsets, parameters.max_lost_contact)
    labels = nearest_pieces(inside, mesh.rings, pieces, distances)
    boundary = len(mesh.corners) * mesh.rings
    labels[:boundary] = mesh.edge
    kept = rooted(labels, mesh.triangles, boundary)
    if not kept.all():
        share = float(weights(mesh.points, mesh.triangles)[~kept].sum())
        if share > parameters.max_cut_off:
            raise ConstructionError(
                "disconnected",
                f"pieces fall apart: {share:.3f} of the area is cut off from its trunk edge "
                f"(allowed {parameters.max_cut_off:g})",
            )
        flood(inside, mesh.triangles, pieces, kept, labels, distances)
    beside = distances_beside(inside, mesh.triangles, pieces, labels, distances)
    return Cells(mesh, labels, mesh.triangles[beside], distances)


def require_contact(
    mesh: Mesh, arcs: FloatArray, offsets: IntArray, allowed: float
) -> tuple[FloatArray, Arcs, FloatArray]:
    """Raise ConstructionError ``lost-contact`` if pieces cover more than the share ``allowed`` of another's trunk edge.

    Returns the mesh points (k, 2) moved a little inwards, the pieces as the kernels read them, and the distances (k, n)
    found on the way, NaN elsewhere.
    """
    corner = mesh.points[mesh.corners[0]]
    first = int(np.argmin(((arcs[offsets[:-1]] - corner) ** 2).sum(axis=1)))
    pieces = boxed(arcs, offsets, first)
    # On a trunk edge itself a region neither begins nor ends: look from just inside.
    inside = mesh.points + INWARD_SHARE * (mesh.points[-1] - mesh.points)
    distances = np.full((len(mesh.points), len(mesh.corners)), np.nan)
    # An empty piece's arc is its edge: what other pieces do not cover by more than the mesh can show is not lost.
    lost = lost_contact(inside, mesh.rings, pieces, distances, CONTACT_SLACK * mesh.spacing)
    for k in np.flatnonzero(lost > allowed):
        raise ConstructionError(
            "lost-contact",
            f"other pieces cover {lost[k]:.0%} of trunk edge {k}, whose own piece must stay on it "
            f"(allowed {allowed:.0%})",
        )
    return inside, pieces, distances

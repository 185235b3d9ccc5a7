"""What was done to an input before it was cut, as JSON values of a ``.riot`` file. Ours.

The field is of second degree on triangles with straight edges in the input's frame: corners and triangles are written,
and where corners and middles of edges go. The middles themselves follow from the corners to the last bit.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from riot import geometry  # lazy: only a transform of bent shapes needs finite elements
from riot.transform import shape_document

if TYPE_CHECKING:
    from riot.geometry.bend import Bend
    from riot.geometry.elements import Elements
    from riot.geometry.shape import Shape
    from riot.types import FloatArray, IntArray


def to_document(bend: Bend) -> dict[str, Any]:
    """A bend as JSON values, but for the bent shape.

    ValueError for a field whose triangles have curved edges in the input's frame, or whose nodes are in another order.
    """
    field = bend.field
    corners, count = field.triangles[:, :3], int(field.triangles[:, 3:].min())
    again = _elements(field.nodes[:count], corners)
    if not (np.array_equal(again.nodes, field.nodes) and np.array_equal(again.triangles, field.triangles)):
        raise ValueError("the nodes of a bend are not those of `riot.geometry.elements.elements_on`")
    return {
        "input": shape_document.to_document(bend.shape),
        "vertices": field.nodes[:count].tolist(),
        "triangles": corners.tolist(),
        "moved": field.moved.tolist(),
        "coefficients": bend.coefficients.tolist(),
        "rms_strain": bend.rms_strain,
        "max_strain": bend.max_strain,
    }


def from_document(document: dict[str, Any], bent: Shape) -> Bend:
    """Read what `to_document` wrote of the bend that gave ``bent``; errors as `shape_document.from_document`."""
    shape = shape_document.from_document(document["input"])
    if len(shape.points) != len(bent.points):
        raise ValueError(f"an input of {len(shape.points)} points bends to one of {len(bent.points)}")
    vertices, corners = shape_document.read_points(document["vertices"]), np.asarray(document["triangles"])
    if corners.ndim != 2 or corners.shape[1] != 3 or len(corners) == 0 or corners.dtype.kind != "i":
        raise ValueError(f"triangles of shape {corners.shape} where (t, 3) whole numbers belong")
    if corners.min() < 0 or corners.max() >= len(vertices):
        raise ValueError("a triangle of a bend has a vertex that is not there")
    with np.errstate(over="ignore", invalid="ignore"):
        elements = _elements(vertices, corners.astype(np.int64))
        proper = (elements.areas > 0.0) & np.isfinite(elements.areas)
    if not (proper.all() and np.isfinite(elements.nodes).all()):
        raise ValueError("a triangle of a bend has no area")
    moved = shape_document.read_points(document["moved"])
    if len(moved) != len(elements.nodes):
        raise ValueError(f"{len(moved)} nodes of a bend are moved, of {len(elements.nodes)}")
    rms_strain, max_strain = shape_document.read_numbers([document["rms_strain"], document["max_strain"]])
    if min(rms_strain, max_strain) < 0.0:
        raise ValueError("a strain is negative")
    coefficients = np.array(shape_document.read_numbers(document["coefficients"]))
    field = geometry.bend.BendField(elements.nodes, moved, elements.triangles)
    return geometry.bend.Bend(shape, bent, coefficients, field, rms_strain, max_strain)


def count_values(document: dict[str, Any]) -> int:
    """How many points, triangles and numbers a bend has; LookupError or TypeError if it is damaged.

    >>> count_values({"input": {"points": [[0, 0]]}, "vertices": [], "triangles": [], "moved": [], "coefficients": [1]})
    2
    """
    names = ("vertices", "triangles", "moved", "coefficients")
    return len(document["input"]["points"]) + sum(len(document[name]) for name in names)


def _elements(vertices: FloatArray, corners: IntArray) -> Elements:
    # Which vertices lie on the outline does not matter to the map.
    return geometry.elements.elements_on(geometry.triangulation.Triangulation(vertices, corners, 0))

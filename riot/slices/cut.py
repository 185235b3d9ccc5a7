"""A solid cut into thick parallel slices, each with straight walls: what is cut is its section half-way up. Ours.

The section half-way up, not the slab's shadow: areas times thickness then add up to the volume as the midpoint rule
does, and the stack is nearest to the object. A slice becomes one outline: the largest polygon of the section,
without its holes, because a shape is one simple polygon. `Slice` tells the area that this leaves out and adds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
import shapely

from riot.errors import ModelError, needs_extra
from riot.geometry.shape import Shape
from riot.geometry.silhouette import polygon_shape
from riot.parameters import ShapeParameters
from riot.slices.model import Model
from riot.slices.tuning import BETTER_IOU, GREATEST_COUNT, SECTIONS_PER_SLICE
from riot.types import FloatArray

with needs_extra("print"):
    import manifold3d

Axis = Literal["x", "y", "z"]
AXES: tuple[Axis, ...] = ("z", "x", "y")
"""An earlier direction is preferred to a later one that is no better."""


_TURNS: dict[Axis, tuple[int, int, int]] = {"x": (1, 2, 0), "y": (2, 0, 1), "z": (0, 1, 2)}
"""Which coordinates of the file become x, y and z of the stack: turns by a third, nothing is mirrored."""


@dataclass(frozen=True)
class Cut:
    """How a solid is to be cut; lengths in mm.

    Of ``count``, ``thickness`` and ``size``, the object's height along the cut, two tell the third; of one alone, the
    height in the file is the other. All three must agree. Slices fill the object's height, so that they stack to it.

    Parameters
    ----------
    count : int, optional
    thickness : float, optional
        Of every slice; rounded to whole ``layer``.
    size : float, optional
    along : "x", "y", "z" or "auto"
        The direction to stack in, as the file has it; auto: the one in which the stack is nearest to the object.
    layer : float
        Layer height of the printer.

    Raises
    ------
    ModelError
        ``sizes``: a number that is not positive, nothing given, or three that do not agree.
    """

    count: int | None = None
    thickness: float | None = None
    size: float | None = None
    along: Axis | Literal["auto"] = "auto"
    layer: float = 0.2

    def __post_init__(self) -> None:
        """Raise `ModelError` for numbers by which no object can be cut."""
        for name, unit in (("count", ""), ("thickness", " mm"), ("size", " mm"), ("layer", " mm")):
            value = getattr(self, name)
            if value is not None and not (math.isfinite(value) and value > 0):
                raise ModelError("sizes", f"{name} is {value:g}{unit}: give a number above 0")
        if self.count is None and self.thickness is None:
            raise ModelError("sizes", "neither count nor thickness is given: give one of them, or both")
        if self.count is not None and self.count > GREATEST_COUNT:
            raise ModelError("sizes", f"{self.count} slices are more than {GREATEST_COUNT}: give a smaller count")
        if None not in (self.count, self.thickness, self.size):
            count, thickness, size = self.count or 0, self.thickness or 0.0, self.size or 0.0
            if abs(count * thickness - size) > count * self.layer:
                raise ModelError(
                    "sizes",
                    f"{count} slices of {thickness:g} mm are {count * thickness:g} mm high, and the object is to be "
                    f"{size:g} mm: leave one of count, thickness and size out, or give a thickness of {size / count:g}",
                )

    def counted(self, height: float) -> tuple[int, float]:
        """Number and thickness (mm, whole layers) of the slices of an object that is so high in its file, mm."""
        size = height if self.size is None else self.size
        thickness = size / self.count if self.thickness is None and self.count is not None else self.thickness
        assert thickness is not None
        thickness = round(max(1, round(thickness / self.layer)) * self.layer, 9)
        count = max(1, round(size / thickness)) if self.count is None else self.count
        if count > GREATEST_COUNT:
            raise ModelError(
                "sizes",
                f"an object of {size:g} mm would be {count} slices of {thickness:g} mm, more than {GREATEST_COUNT}: "
                "give a greater thickness or a smaller size",
            )
        return count, thickness


@dataclass(frozen=True, eq=False)
class Slice:
    """One slice; mm, in the stack's frame: the object's box starts at the origin, z is the direction of stacking.

    Parameters
    ----------
    number : int
        From 1, the lowest.
    low, high : float
        Where it lies.
    section : shapely.Geometry
        The object's, half-way up.
    outline : shapely.Polygon
        What becomes a shape: the largest polygon of the section, without its holes.
    """

    number: int
    low: float
    high: float
    section: shapely.Geometry
    outline: shapely.Polygon

    @property
    def area(self) -> float:
        """Of the outline, mm²."""
        return float(self.outline.area)

    @property
    def filled(self) -> float:
        """Area of the section's holes, which the outline covers, mm²."""
        return max(0.0, self.area - float(shapely.intersection(self.section, self.outline).area))

    @property
    def lost(self) -> float:
        """Area of the section outside the outline, which the slice leaves out, mm²."""
        return float(shapely.difference(self.section, self.outline).area)

    def shape(self, name: str, parameters: ShapeParameters | None = None) -> Shape:
        """The outline as a shape, whose ``to_source`` gives mm; raises `riot.errors.SilhouetteError`."""
        return polygon_shape(shapely.get_coordinates(self.outline.exterior)[:-1], name, parameters)


@dataclass(frozen=True, eq=False)
class Stack:
    """The slices of an object, lowest first.

    Parameters
    ----------
    name : str
        The object's.
    along : "x", "y" or "z"
        Direction of stacking, as the file has it.
    scale : float
        mm of the stack per mm of the file.
    thickness : float
        Of a slice, mm.
    solid : manifold3d.Manifold
        The object in the stack's frame, mm.
    slices : tuple of Slice
    iou : float
        Volume that stack and object share, over that of both together, at `SECTIONS_PER_SLICE` sections a slice.
    """

    name: str
    along: Axis
    scale: float
    thickness: float
    solid: manifold3d.Manifold
    slices: tuple[Slice, ...]
    iou: float

    @property
    def height(self) -> float:
        """Of the whole stack, mm."""
        return len(self.slices) * self.thickness

    def upright(self, points: FloatArray) -> FloatArray:
        """(k, 3) points of the stack turned as the file has them, mm."""
        turned = np.empty_like(points)
        turned[:, _TURNS[self.along]] = points
        return turned


def cut(model: Model, how: Cut) -> Stack:
    """Cut a solid, scaled so that the slices fill its height.

    Raises `ModelError`: ``sizes``, or ``empty-slice`` where the section half-way up a slice has no area.
    """
    if how.along != "auto":
        return _cut(model, how, how.along)
    best: Stack | None = None
    error: ModelError | None = None
    for axis in AXES:
        try:
            stack = _cut(model, how, axis)
        except ModelError as caught:
            error = error or caught
            continue
        if best is None or stack.iou > best.iou + BETTER_IOU:
            best = stack
    if best is None:
        assert error is not None
        raise error
    return best


def section(solid: manifold3d.Manifold, height: float) -> shapely.Geometry:
    """The region of a solid in the plane at a height, with its holes."""
    contours = solid.slice(height)
    polygons = []
    for contour in [] if contours.is_empty() else contours.decompose():
        rings = sorted(
            (np.asarray(ring, dtype=np.float64) for ring in contour.to_polygons()), key=_extent, reverse=True
        )
        polygons.append(shapely.Polygon(rings[0], rings[1:]))
    return shapely.MultiPolygon(polygons)


def _extent(ring: FloatArray) -> float:
    return float(np.ptp(ring, axis=0).max())


def _cut(model: Model, how: Cut, axis: Axis) -> Stack:
    turn = _TURNS[axis]
    count, thickness = how.counted(model.size[turn[2]])
    scale = count * thickness / model.size[turn[2]]
    matrix = np.zeros((3, 4))
    matrix[np.arange(3), turn] = scale
    matrix[:, 3] = -scale * np.array(model.solid.bounding_box()[:3])[list(turn)]
    solid = model.solid.transform(matrix)
    slices = tuple(_slice(solid, k, thickness, count, f"{model.name}, along {axis}") for k in range(count))
    return Stack(model.name, axis, scale, thickness, solid, slices, _iou(solid, slices))


def _slice(solid: manifold3d.Manifold, k: int, thickness: float, count: int, where: str) -> Slice:
    low, high = k * thickness, (k + 1) * thickness
    whole = section(solid, 0.5 * (low + high))
    if whole.is_empty or whole.area <= 0.0:
        raise ModelError(
            "empty-slice",
            f"{where}: slice {k + 1} of {count} has no area half-way up, {0.5 * (low + high):.1f} mm over the "
            "foot: the object is in parts there; give fewer, thicker slices, or cut another way (along)",
        )
    largest = max((shapely.Polygon(polygon.exterior) for polygon in shapely.get_parts(whole)), key=shapely.area)
    return Slice(k + 1, low, high, whole, largest)


def _iou(solid: manifold3d.Manifold, slices: tuple[Slice, ...]) -> float:
    shared = both = 0.0
    for slice_ in slices:
        for share in (np.arange(SECTIONS_PER_SLICE) + 0.5) / SECTIONS_PER_SLICE:
            here = section(solid, slice_.low + float(share) * (slice_.high - slice_.low))
            common = float(shapely.intersection(here, slice_.outline).area)
            shared += common
            both += float(here.area) + slice_.area - common
    return shared / both

"""The classes that ``riot`` offers: `Shape` and `Transform`, data, with the functions of other packages as methods.

Below, nothing calls these methods: a package calls the functions of the packages beneath it. The methods are declared
in subclasses for the sake of type checkers, and attached to the classes of the data themselves, so that
``riot.Transform is riot.transform.transform.Transform`` and every transform has them, whoever made it.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ParamSpec, Protocol, TypeVar, cast

import numpy.typing as npt
from PIL.Image import Image

from riot import draw, geometry
from riot.construction import plan, trunk_choice
from riot.content import count
from riot.geometry import shape as shape_module
from riot.motion import planner
from riot.parameters import ShapeParameters
from riot.scores import trunks as trunks_module
from riot.scores.crs import CrossScore
from riot.scores.qcrs import QuickScore
from riot.scores.reversibility import Reversibility
from riot.transform import certificate, deformation, riot_file
from riot.transform import transform as transform_module
from riot.transform.motion import Motion

Class = TypeVar("Class", bound=type)
Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")


class SupportsGeoInterface(Protocol):
    """What geographic libraries agree on: an object that says what it is as GeoJSON."""

    @property
    def __geo_interface__(self) -> Mapping[str, Any]:
        """A GeoJSON geometry, feature or collection."""


_OFFERED = ("__repr__", "__geo_interface__")
"""Special names that these classes declare; all others of a class body are Python's own."""


def _attach_to_base(methods: Class) -> Class:
    """Give the base of a class what the class declares, and put the base in its place."""
    base = methods.__base__
    for name, method in vars(methods).items():
        if not name.startswith("__") or name in _OFFERED:
            setattr(base, name, method)
    return cast(Class, base)


@_attach_to_base
class Shape(shape_module.Shape):
    """A silhouette as a polygon; see `riot.geometry.shape.Shape`."""

    @classmethod
    def from_image(
        cls,
        image: str | os.PathLike[str] | npt.ArrayLike | Image,
        parameters: ShapeParameters | None = None,
        name: str = "",
    ) -> Shape:
        """Read the silhouette in a picture: a file, an array of pixels, or a Pillow image.

        See `riot.geometry.silhouette.read_image` for files and `riot.geometry.pixels.pixels_shape` for the others.
        The name is by default that of the file.

        >>> from PIL import Image, ImageDraw
        >>> picture = Image.new("L", (256, 256))
        >>> ImageDraw.Draw(picture).ellipse((8, 8, 248, 248), fill=255)
        >>> round(Shape.from_image(picture, name="disc").perimeter, 1)  # 2√π
        3.5
        >>> picture.save("disc.png")
        >>> Shape.from_image("disc.png") == Shape.from_image(picture, name="disc")
        True
        """
        if isinstance(image, str | os.PathLike):
            shape = geometry.silhouette.read_image(image, parameters)
            return cast(Shape, shape.renamed(name) if name else shape)
        return cast(Shape, geometry.pixels.pixels_shape(image, name, parameters))

    @classmethod
    def from_svg(cls, path: str | os.PathLike[str], parameters: ShapeParameters | None = None) -> Shape:
        """Read the outline in a vector file; see `riot.geometry.silhouette.read_svg`.

        >>> from pathlib import Path
        >>> text = '<svg xmlns="http://www.w3.org/2000/svg"><rect width="30" height="10"/></svg>'
        >>> _ = Path("bar.svg").write_text(text)
        >>> round(Shape.from_svg("bar.svg").perimeter, 3)  # 8/√3
        4.619
        """
        return cast(Shape, geometry.silhouette.read_svg(path, parameters))

    @classmethod
    def from_polygon(
        cls,
        polygon: npt.ArrayLike | Mapping[str, Any] | SupportsGeoInterface,
        name: str = "",
        parameters: ShapeParameters | None = None,
    ) -> Shape:
        """Make a shape of a polygon in either orientation, y upwards.

        ``polygon`` is an (m, 2) array; a polygon of shapely or any other object with ``__geo_interface__``, such as an
        element of a GeoSeries; or a GeoJSON mapping. Holes are filled, with a warning. The name is by default that in
        a feature's properties. Coordinates are taken as they are: project degrees first. See
        `riot.geometry.silhouette.polygon_shape` and `riot.geometry.geojson.read_outer_ring`, also for errors.

        >>> round(Shape.from_polygon([(0, 0), (4, 0), (4, 3)], name="triangle").perimeter, 3)  # of unit area
        4.899
        >>> import shapely
        >>> Shape.from_polygon(shapely.box(0, 0, 9, 1), name="bar")
        Shape('bar', 288 points)
        """
        ring = geometry.geojson.read_outer_ring(polygon, name or "the polygon")
        return cast(Shape, geometry.silhouette.polygon_shape(ring.points, name or ring.name, parameters))

    def _repr_svg_(self) -> str:
        return draw.notebook.shape_svg(self)

    def _repr_html_(self) -> str:
        return draw.notebook.shape_html(self)

    @property
    def __geo_interface__(self) -> dict[str, Any]:
        """The outline, in the unit-area frame, as a GeoJSON feature with the shape's name; `source` maps points back.

        >>> import shapely.geometry
        >>> round(shapely.geometry.shape(house).area, 9)
        1.0
        """
        return geometry.geojson.polygon_feature(self.points, name=self.name)


@_attach_to_base
class Trunks(trunks_module.Trunks):
    """The candidate trunks of one shape; see `riot.scores.trunks.Trunks`."""

    def on(self, shape: Shape, numbers: Sequence[int] | None = None) -> TrunksOnShape:
        """A picture, for notebooks, of trunks on the shape that has them: of a dozen, evenly chosen, or of ``numbers``.

        >>> trunks(house).on(house, [0, 1])
        TrunksOnShape(trunks=Trunks(1455 trunks, 3 to 5 vertices), shape=Shape('house', 160 points), numbers=(0, 1))
        """
        chosen = draw.notebook.evenly(len(self)) if numbers is None else numbers
        return TrunksOnShape(self, shape, tuple(chosen))

    def _repr_html_(self) -> str:
        return draw.result_table.table_html(self)


@dataclass(frozen=True)
class TrunksOnShape:
    """Trunks with their shape, which a notebook shows as a picture; see `Trunks.on`."""

    trunks: Trunks
    shape: Shape
    numbers: tuple[int, ...]

    def _repr_html_(self) -> str:
        return draw.notebook.trunks_html(self.shape, self.trunks, self.numbers)


@_attach_to_base
class ConstructionPlan(plan.ConstructionPlan):
    """Conjugate trunks of two shapes; see `riot.construction.plan.ConstructionPlan`."""

    def __repr__(self) -> str:
        names = f"{self.pair.p.name!r} ⇄ {self.pair.q.name!r}"
        return f"ConstructionPlan({names}, {len(self.trunk_p)} vertices, IoU ≤ {self.bound:.3f})"

    def _repr_html_(self) -> str:
        return draw.notebook.plan_html(self)


for _result in (Reversibility, QuickScore, CrossScore, certificate.Certificate, deformation.Deformation):
    setattr(_result, "_repr_html_", lambda self: draw.result_table.table_html(self))  # noqa: B010 (mypy knows none)


@_attach_to_base
class Transform(transform_module.Transform):
    """An exact reversible transform; see `riot.transform.transform.Transform`."""

    def __repr__(self) -> str:
        """One line; the certificate and the IoU in it are computed once for each transform."""
        words = "exact" if self.certificate().passed else "approximate"
        names = f"{self.p.name!r} ⇄ {self.q.name!r}"
        return f"Transform({names}, {count(len(self), 'piece')}, IoU {min(self.overlap_ratios):.3f}, {words})"

    def _repr_html_(self) -> str:
        return draw.notebook.transform_html(self, repr(self).removeprefix("Transform(").removesuffix(")"))

    @property
    def __geo_interface__(self) -> dict[str, Any]:
        """The pieces, where they make P and again where they make Q, as a GeoJSON collection of features.

        The properties of a feature are ``piece``, its number in the chain, and ``shape``, "P" or "Q", in whose frame
        its outline is; ``name`` is that shape's name.

        >>> pieces = transform.__geo_interface__["features"]
        >>> len(pieces), pieces[0]["properties"]
        (8, {'piece': 0, 'shape': 'P', 'name': 'house'})
        """
        features = [
            geometry.geojson.polygon_feature(outline, piece=piece, shape=side, name=name)
            for side, t, name in (("P", 0.0, self.p.name), ("Q", 1.0, self.q.name))
            for piece, outline in enumerate(self.parts(self.pose(t)))
        ]
        return {"type": "FeatureCollection", "features": features}

    def certificate(self) -> certificate.Certificate:
        """Verify the two assemblies, once; see `riot.transform.certificate.certify`.

        >>> transform.certificate().passed
        True
        """
        return certificate.certify(self)

    @property
    def overlap_ratios(self) -> tuple[float, float]:
        """IoU of the assembled P with P, and of the assembled Q with Q."""
        return deformation.overlap_ratios(self)

    def deformation(self) -> deformation.Deformation:
        """Compare the two assemblies with the inputs; see `riot.transform.deformation.measure_deformation`.

        >>> 0.95 < transform.deformation().iou < 1.0
        True
        """
        return deformation.measure_deformation(self)

    def motion(self) -> Motion:
        """How the pieces swing from P to Q without collision; see `riot.motion.planner.motion_of`.

        >>> transform.motion().words
        'swings flat'
        """
        return planner.motion_of(self)

    def planned(self) -> Transform:
        """The transform with its motion as ``plan``, to be saved with it.

        >>> transform.planned().plan.flat
        True
        """
        return cast(Transform, planner.with_motion(self))

    def draw(self, path: str | os.PathLike[str]) -> None:
        """Draw inputs, trunks, both dissections and the chain; the suffix (svg, png, pdf) chooses the format.

        >>> transform.draw("house-kite.svg")
        """
        draw.draw_transform(self, path)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a ``.riot`` file: JSON, exact to the last bit; `load` reads it back equal.

        >>> transform.save("house-kite.riot")
        >>> len(Transform.load("house-kite.riot"))
        4
        """
        riot_file.save(self, path)

    @staticmethod
    def load(path: str | os.PathLike[str]) -> Transform:
        """Read a ``.riot`` file; raises `riot.errors.FormatError` if it is none, or of an unknown version.

        >>> transform.save("house-kite.riot")
        >>> Transform.load("house-kite.riot").p.name
        'house'
        """
        return cast(Transform, riot_file.load(path))


def _returning(function: Callable[Parameters, object], result: type[Result]) -> Callable[Parameters, Result]:
    """The function itself, for type checkers one whose result has the methods."""
    return cast(Callable[Parameters, Result], function)


construct = _returning(trunk_choice.construct, Transform)
trunks = _returning(trunks_module.trunks, Trunks)

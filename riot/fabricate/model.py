"""A design: the flat pieces of the puzzle in millimetres, their hinges and the layers of their solids. Ours."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
import shapely

from riot.fabricate.pivot import Pivot
from riot.fabricate.pocket import Pocket
from riot.fabricate.rings import Ring
from riot.fabricate.telescope import Telescope
from riot.parameters import FabricationParameters
from riot.transform.motion import Motion
from riot.transform.pose import Pose
from riot.transform.transform import Transform
from riot.types import FloatArray

Kind = Literal["pin", "telescopic", "open"]
Role = Literal["lower", "upper", "none"]


@dataclass(frozen=True)
class HingeEnd:
    """What one piece has at one of its two hinges.

    Parameters
    ----------
    hinge : int
        Which hinge of the transform.
    kind : "pin", "telescopic" or "open"
        An open hinge has no knuckles: it joins nothing.
    role : "lower", "upper" or "none"
        Lower: the knuckle that holds the pin, or the barrel of a telescopic hinge; upper: the one that turns, or the
        rod. Both ends of a piece have the same.
    x, y : float
        The axis in the piece's frame, mm.
    rings : tuple of Ring
        The knuckle, or the barrel, or the rod and its cap.
    relief : tuple of Ring
        The room that the piece makes for its neighbour's knuckles.
    relief_radius : float
        Of that room where it is widest, mm.
    captive : float
        Height up to which the piece has only a pin here, in the socket of the other piece, mm; 0 where it has none.
    """

    hinge: int
    kind: Kind
    role: Role
    x: float
    y: float
    rings: tuple[Ring, ...]
    relief: tuple[Ring, ...]
    relief_radius: float
    captive: float = 0.0

    @property
    def radius(self) -> float:
        """Of the widest knuckle, mm; 0 at an open hinge."""
        return max((ring.radius for ring in self.rings), default=0.0)


@dataclass(frozen=True, eq=False)
class Slab:
    """A layer of a solid between the heights ``low`` and ``high`` (mm): every level cut in it is ``section``."""

    low: float
    high: float
    section: shapely.Geometry

    @property
    def volume(self) -> float:
        """In mm³."""
        return float(self.section.area) * (self.high - self.low)


@dataclass(frozen=True, eq=False)
class PieceDesign:
    """One piece, in its own frame in mm: the trunk edge on the x-axis from (0, 0) to (length, 0), z up.

    Parameters
    ----------
    index : int
        In the chain.
    length : float
        Of its trunk edge.
    outline : (m, 2) float64
        The flat piece, counter-clockwise, each point once: half the outline gap is taken off all round; no hinges.
    body : shapely.Polygon
        The same without what other pieces' knuckles sweep on their way.
    start, end : HingeEnd
        At (0, 0), hinge ``index``, and at (length, 0), the next hinge.
    slabs : tuple of Slab
        The solid, from the lowest layer up.
    lost : float
        Share of the outline's area that other pieces' knuckles take.
    upside_down : bool
        Whether it is printed lying on its upper face.
    pockets : tuple of Pocket
        For magnets, in its walls.
    """

    index: int
    length: float
    outline: FloatArray
    body: shapely.Polygon
    start: HingeEnd
    end: HingeEnd
    slabs: tuple[Slab, ...]
    lost: float
    upside_down: bool
    pockets: tuple[Pocket, ...] = ()

    @property
    def name(self) -> str:
        """As in file names: ``piece-1`` is piece 0."""
        return f"piece-{self.index + 1}"

    @property
    def footprint(self) -> shapely.Geometry:
        """All that is solid at some height, holes filled."""
        return filled(shapely.union_all([slab.section for slab in self.slabs]))

    @property
    def hinge_share(self) -> float:
        """Area of the discs in which its hinges turn over the area of its outline."""
        discs = sum(math.pi * end.relief_radius**2 for end in (self.start, self.end))
        return discs / float(shapely.Polygon(self.outline).area)

    @property
    def volume(self) -> float:
        """Sum of the layers', mm³."""
        return sum(slab.volume for slab in self.slabs)


@dataclass(frozen=True)
class HingePin:
    """What pin hinges turn on: printed pins, rods to be cut to length, or screws with nuts; mm, and how many."""

    kind: Literal["printed", "rod", "screw"]
    diameter: float
    length: float
    count: int


@dataclass(frozen=True)
class Placement:
    """The pose in which a chain is printed in place.

    ``time`` is the motion's; ``turn`` (radians, about the pose's origin) lays the box around it straight, ``width`` by
    ``depth`` mm, the longer first; ``gap`` is the least between two pieces, mm, `GAP_CAP_MM` or more if it is wider.
    """

    time: float
    turn: float
    width: float
    depth: float
    gap: float


@dataclass(frozen=True, eq=False)
class Design:
    """A puzzle to be made.

    Parameters
    ----------
    transform : Transform
    parameters : FabricationParameters
    scale : float
        mm per unit of the transform's frame.
    motion : Motion
        The planned motion that the pieces are cleared for.
    pieces : tuple of PieceDesign
        In chain order.
    pins : tuple of HingePin
        Empty if no hinge has one.
    pivot : Pivot or None
        The pin hinges, if there are any.
    telescope : Telescope or None
        The telescopic hinges, if the motion lifts any.
    warnings : tuple of str
        What is weak or lost; nothing that stops the puzzle from being made.
    placement : Placement or None
        How the chain lies on the bed if it is printed in place.
    """

    transform: Transform
    parameters: FabricationParameters
    scale: float
    motion: Motion
    pieces: tuple[PieceDesign, ...]
    pins: tuple[HingePin, ...]
    pivot: Pivot | None
    telescope: Telescope | None
    warnings: tuple[str, ...]
    placement: Placement | None = None

    @property
    def sleeves(self) -> int:
        """How many sleeves of telescopic hinges there are."""
        return len(self.motion.lifted)

    @property
    def stackable(self) -> bool:
        """Whether all its hinges are knuckles on knuckles, which can be stacked from sheets."""
        return self.telescope is None and self.placement is None

    @property
    def lift(self) -> float:
        """Height of one plane of the motion over the next lower, mm."""
        return self.parameters.travel

    def place(self, pose: Pose, piece: int, points: FloatArray) -> FloatArray:
        """Map (k, 2) points in mm of a piece's frame to where a pose of the transform has them, mm."""
        placed: FloatArray = self.scale * pose.place(piece, np.asarray(points) / self.scale)
        return placed


def printed_upside_down(ends: tuple[HingeEnd, HingeEnd]) -> bool:
    """Whether a piece with such ends is printed lying on its upper face."""
    return any(end.role == "upper" and not end.captive for end in ends)


def filled(region: shapely.Geometry) -> shapely.Geometry:
    """A region with its holes filled."""
    outlines = [shapely.Polygon(polygon.exterior) for polygon in polygons(region)]
    return shapely.union_all(outlines) if len(outlines) != 1 else outlines[0]


def polygons(region: shapely.Geometry) -> list[shapely.Polygon]:
    """The polygons of a region, without those that have no area."""
    return [polygon for polygon in shapely.get_parts(region) if polygon.geom_type == "Polygon" and polygon.area > 0.0]

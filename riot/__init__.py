"""RIOT: pairs of silhouettes that turn inside out into each other, and the pieces that do it.

>>> from riot import Shape, construct, crs, qcrs, reversibility, trunks

A `Shape` is read from a picture, a vector file or a polygon; `reversibility`, `qcrs` and `crs` score one shape or
two; `trunks` lists the convex polygons on which a dissection may rest; `construct` cuts the pieces and returns a
`Transform`.
"""

from riot.construct import Pins, alternatives, construct, load_pins
from riot.cross import CrossScore, crs
from riot.errors import ConstructionError, FormatError, RiotError, SilhouetteError, TrunkError
from riot.quick import QuickScore, qcrs
from riot.reversibility import Reversibility, reversibility
from riot.shape import Shape
from riot.transform import Transform
from riot.trunks import Trunks, trunks

__all__ = [
    "ConstructionError",
    "CrossScore",
    "FormatError",
    "Pins",
    "QuickScore",
    "Reversibility",
    "RiotError",
    "Shape",
    "SilhouetteError",
    "Transform",
    "TrunkError",
    "Trunks",
    "alternatives",
    "construct",
    "crs",
    "load_pins",
    "qcrs",
    "reversibility",
    "trunks",
]

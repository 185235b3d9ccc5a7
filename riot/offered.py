"""What ``riot`` offers."""

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

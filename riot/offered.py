"""What ``riot`` offers."""

from riot.construction import Pins, alternatives, construct, load_pins
from riot.errors import ConstructionError, FormatError, RiotError, SilhouetteError, TrunkError
from riot.geometry.shape import Shape
from riot.scores.crs import CrossScore, crs
from riot.scores.qcrs import QuickScore, qcrs
from riot.scores.reversibility import Reversibility, reversibility
from riot.scores.trunks import Trunks, trunks
from riot.transform.transform import Transform

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

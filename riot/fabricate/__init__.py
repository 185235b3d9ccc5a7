"""Fabrication: from a transform to a puzzle in the hand (paper §4.4). All lengths in millimetres."""

from riot.fabricate.design import design
from riot.fabricate.errors import FabricationError
from riot.fabricate.model import Design, PieceDesign
from riot.fabricate.parameters import FabricationParameters

__all__ = ["Design", "FabricationError", "FabricationParameters", "PieceDesign", "design"]

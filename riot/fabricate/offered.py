"""What ``riot.fabricate`` offers."""

from riot.errors import FabricationError
from riot.fabricate.certificate import Built, FabricationCertificate, build, certify, fix
from riot.fabricate.design import design
from riot.fabricate.export.solids import write_puzzle
from riot.fabricate.model import Design, PieceDesign
from riot.fabricate.solid import Part, make_parts
from riot.parameters.fabrication import FabricationParameters

__all__ = [
    "Built",
    "Design",
    "FabricationCertificate",
    "FabricationError",
    "FabricationParameters",
    "Part",
    "PieceDesign",
    "build",
    "certify",
    "design",
    "fix",
    "make_parts",
    "write_puzzle",
]

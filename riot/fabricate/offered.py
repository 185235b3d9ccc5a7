"""What ``riot.fabricate`` offers."""

from riot.fabricate.certificate import Built, FabricationCertificate, build, certify, fix
from riot.fabricate.design import design
from riot.fabricate.errors import FabricationError
from riot.fabricate.files import write_puzzle
from riot.fabricate.model import Design, PieceDesign
from riot.fabricate.parameters import FabricationParameters
from riot.fabricate.solid import Part, make_parts

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

"""The check of a part by itself: one closed solid, as thick as it must be, with the volume of its layers. Ours."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import shapely
from shapely import affinity

from riot.errors import FabricationError, needs_extra
from riot.fabricate.model import Design, PieceDesign
from riot.fabricate.outlines import narrowest, widening_parameter
from riot.fabricate.overhang import SupportCheck, check_supports
from riot.fabricate.pivot import knuckle_radius
from riot.fabricate.solid import Part, genus
from riot.fabricate.tuning import (
    FILAMENT_MM,
    LARGEST_HINGE_SHARE,
    LEAST_WALL_MM,
    OUTLINE_SPARE_MM,
    THINNEST_WAIST_MM,
    VOLUME_TOLERANCE,
)
from riot.parameters import FabricationParameters

with needs_extra("print"):
    import manifold3d


@dataclass(frozen=True)
class PartCheck:
    """One part: what manifold3d says of it beside what its flat layers say; mm, mm³.

    ``wall`` is the least width of a layer, pin holes filled, ``hinge_share`` what its hinges take of its area; NaN for
    what is not a piece. ``mend`` is the parameter to change if a check fails, ``value`` the least value of it that
    will do, NaN if that is not known.
    """

    name: str
    count: int
    status: str
    components: int
    volume: float
    layers_volume: float
    genus: int
    layers_genus: int
    wall: float
    hinge_share: float
    supports: SupportCheck
    mend: str
    value: float
    failures: tuple[str, ...] = field(default=())


def check_part(part: Part, design: Design) -> PartCheck:
    """Verify one part by itself."""
    piece = next((piece for piece in design.pieces if piece.name == part.name), None)
    status = part.solid.status()
    volume, expected = part.volume, sum(slab.volume for slab in part.slabs)
    components = len(part.solid.decompose())
    handles, expected_handles = int(part.solid.genus()), genus(part.slabs)
    wall = math.nan if piece is None else narrowest(piece)
    failures = []
    if status != manifold3d.Error.NoError or part.solid.is_empty():
        failures.append(f"{part.name} is no closed solid ({status.name})")
    if components != 1:
        failures.append(f"{part.name} is in {components} parts: enlarge size_mm")
    if abs(volume - expected) > VOLUME_TOLERANCE * expected:
        failures.append(f"{part.name} has {volume:.3f} mm³ where its layers have {expected:.3f}")
    if handles != expected_handles:
        failures.append(f"{part.name} has {handles} handles where its layers have {expected_handles}")
    mend, value = "size_mm", math.nan
    if piece is not None and wall < LEAST_WALL_MM:
        mend = widening_parameter(piece, LEAST_WALL_MM)
        failures.append(
            f"{part_words(piece)} is only {wall:.2f} mm wide where a "
            f"knuckle or a good part of it hangs on it, less than {LEAST_WALL_MM:g}: enlarge {mend}"
        )
    if piece is not None and (large := large_hinges(piece, design)) is not None:
        mend, (words, value) = "size_mm", large
        failures.append(words)
    supports = check_supports(part, design.parameters.layer_mm)
    failures += supports.failures
    share = math.nan if piece is None else piece.hinge_share
    return PartCheck(
        part.name,
        part.count,
        status.name,
        components,
        volume,
        expected,
        handles,
        expected_handles,
        wall,
        share,
        supports,
        mend,
        value,
        tuple(failures),
    )


def size_for_hinges(piece: PieceDesign, design: Design, parameters: FabricationParameters | None = None) -> float:
    """The least size in whole mm at which a piece's hinges take no more than the largest share of it.

    With other ``parameters`` the hinges are theirs.
    """
    parameters = parameters or design.parameters
    raw = shapely.Polygon(design.transform.pieces[piece.index].polygon)
    unit = design.scale / design.parameters.size_mm
    pin = knuckle_radius(parameters) + parameters.gap_mm + OUTLINE_SPARE_MM
    radii = [pin if end.kind == "pin" else end.relief_radius for end in (piece.start, piece.end)]
    needed = math.pi * sum(radius**2 for radius in radii) / LARGEST_HINGE_SHARE
    size = math.floor(math.sqrt(needed / raw.area) / unit)
    while (
        affinity.scale(raw, size * unit, size * unit).buffer(-0.5 * parameters.gap_mm - OUTLINE_SPARE_MM).area < needed
    ):
        size += 1
    return float(size)


def large_hinges(piece: PieceDesign, design: Design) -> tuple[str, float] | None:
    """What is wrong with a piece's hinges, and at which sizes it is not, with these and with thinner ones; None if they
    are small enough. Areas tell: no solid is built."""
    if piece.hinge_share <= LARGEST_HINGE_SHARE:
        return None
    parameters, size = design.parameters, size_for_hinges(piece, design)
    ways = [f"enlarge size_mm ({parameters.size_mm:g}) to {size:g}"]
    thin_pin = thinner_pin(parameters) or parameters
    rod = f"filament for pins (pivot=rod, pin_mm={FILAMENT_MM:g})"
    for words, thinner in (
        (f"wall_mm={LEAST_WALL_MM:g}", replace(parameters, wall_mm=LEAST_WALL_MM)),
        (rod if thin_pin.pivot == "rod" else f"pin_mm={thin_pin.pin_mm:g}", thin_pin),
    ):
        if knuckle_radius(thinner) < knuckle_radius(parameters):
            least = size_for_hinges(piece, design, thinner)
            ways.append(f"to {least:g} with {words}" if least > parameters.size_mm else f"take {words}")
    words = (
        f"{part_words(piece)}: its hinges are {piece.hinge_share:.0%} as large as it, more than "
        f"{LARGEST_HINGE_SHARE:.0%}: {', or '.join(ways)}"
    )
    return words, size


def refuse_large_hinges(design: Design) -> None:
    """Raise `riot.errors.FabricationError` ``uncertified`` if hinges are too large for their pieces, with the size at
    which none are; so that sizes are found from areas before anything is built."""
    large = [found for piece in design.pieces if (found := large_hinges(piece, design)) is not None]
    if large:
        raise FabricationError(
            "uncertified", "; ".join(words for words, _ in large), "size_mm", max(size for _, size in large)
        )


def thinner_pin(parameters: FabricationParameters) -> FabricationParameters | None:
    """The same with the thinnest pin: filament, or the thinnest waist of one that is printed in place; None if it is
    so thin already."""
    if parameters.pivot == "in-place":
        return replace(parameters, pin_mm=THINNEST_WAIST_MM) if parameters.pin_mm > THINNEST_WAIST_MM else None
    return replace(parameters, pin_mm=FILAMENT_MM, pivot="rod") if parameters.pin_mm > FILAMENT_MM else None


def part_words(piece: PieceDesign) -> str:
    """A piece and its hinges in words."""
    return f"{piece.name} (hinges {piece.start.hinge} and {piece.end.hinge})"

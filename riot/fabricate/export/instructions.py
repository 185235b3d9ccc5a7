"""What the assembly page says in words: steps, sizes, pins and hinges. Ours."""

from __future__ import annotations

import re
import textwrap
from typing import TYPE_CHECKING

from riot.fabricate.export.sheets import LONGEST_NAME

if TYPE_CHECKING:
    from riot.fabricate.model import Design, HingeEnd

_NOUNS = {"printed": "pins", "rod": "rods with caps", "screw": "countersunk screws with nuts"}
PIN_STEPS = {
    "printed": "Press a pin through both from above, until its head is flush.",
    "rod": "Press a rod through both until it is flush below, then a cap on it from above.",
    "screw": "Lay a nut into the pocket below, and turn a screw into it from above until the knuckle just turns; "
    "a drop of glue on the nut keeps it so.",
}
"""How two knuckles that lie on each other are joined, by the kind of pin."""


IN_PLACE_STEPS = (
    "Take the chain off the bed as it is: it is printed in one, with its hinges.",
    "Turn every hinge to and fro, a little further each time, until it is free.",
)
"""What comes first with a chain that is printed in place."""


def shape_names(design: Design) -> tuple[str, str]:
    """The names of P and Q, no longer than fits."""
    p, q = design.transform.p.name or "P", design.transform.q.name or "Q"
    return textwrap.shorten(p, LONGEST_NAME, placeholder="…"), textwrap.shorten(q, LONGEST_NAME, placeholder="…")


def steps(design: Design) -> list[str]:
    """What to do with the pieces, sentence by sentence."""
    n, motion = len(design.pieces), design.motion
    first = motion.open_hinge
    order = [(first + k) % n + 1 for k in range(n)]
    if design.placement is not None:
        return [*IN_PLACE_STEPS, *magnet_steps(design), *_shut(design, order)]
    sentences = [f"Lay the pieces on the table, fronts up, in this order: {', '.join(map(str, order))}."]
    sentences += magnet_steps(design)
    if design.pins:
        sentences.append(
            "At every pin hinge lay the knuckle of one piece on that of the next. " + PIN_STEPS[design.pins[0].kind]
        )
    if motion.lifted:
        joined = ", ".join(f"{(hinge - 1) % n + 1} and {hinge + 1}" for hinge in motion.lifted)
        sentences.append(
            f"Between pieces {joined}: push a sleeve into the barrel from below, then the slit rod of the other piece "
            "into the sleeve from above, until both snap."
        )
    return sentences + _shut(design, order)


def magnet_steps(design: Design) -> list[str]:
    """What to do with the magnets, if there are any."""
    pieces = {pocket.pole: piece.index + 1 for piece in design.pieces for pocket in piece.pockets}
    if not pieces:
        return []
    return [
        "Stack the magnets and mark their upper faces. Glue one into each hole in a wall: marks outside in piece "
        f"{pieces['north']}, inside in piece {pieces['south']}."
    ]


def _shut(design: Design, order: list[int]) -> list[str]:
    """What to do with the chain, whose pieces have these numbers in this order."""
    names = shape_names(design)
    sentences = [f"Pieces {order[-1]} and {order[0]} are the free ends: nothing joins them."]
    sentences.append(f"Swing the chain shut one way for {names[0]}, and the other way for {names[1]}.")
    if design.transform.mirrored_q:
        sentences.append(f"Turn the puzzle over: {names[1]} is on its back.")
    return sentences


def sizes(design: Design) -> list[str]:
    """The measures of the design, line by line."""
    parameters = design.parameters
    return [
        f"long side {parameters.size_mm:g} mm, thickness {parameters.height:g} mm, layer {parameters.layer_mm:g} mm",
        f"{'waist of the pins' if design.placement else 'pin'} {parameters.pin_mm:g} mm; clearance "
        f"{parameters.clearance_mm:g} mm where it turns"
        + (
            f", {parameters.press_mm:g} mm thicker than its hole where it is held"
            if parameters.pivot in ("printed", "rod")
            else ""
        ),
        f"between outlines {parameters.gap_mm:g} mm, between knuckles {parameters.axial_gap:g} mm; "
        f"laser kerf {parameters.kerf_mm:g} mm",
        "Clearances are from makers' literature, not from our own prints: print one hinge first.",
    ]


def warnings(design: Design) -> list[str]:
    """The warnings of the design, with the options of `riot print` for the parameters that they name."""
    return [re.sub(r"\b([a-z_]+)_mm\b", _option, words) for words in design.warnings]


def _option(parameter: re.Match[str]) -> str:
    return f"--{parameter[1].replace('_', '-')}"


def pins_in_words(design: Design) -> str:
    """How many pins of each kind, sleeves and magnets."""
    words = [f"{pin.count} {_NOUNS[pin.kind]} ⌀ {pin.diameter:g} × {pin.length:g} mm" for pin in design.pins]
    if design.sleeves:
        words.append(f"{design.sleeves} sleeve{'s' if design.sleeves > 1 else ''}")
    if not words:
        words.append("hinges printed in place" if design.placement else "no pins")
    if count := sum(len(piece.pockets) for piece in design.pieces):
        words.append(f"{count} disc magnets {magnet_size(design)}")
    return ", ".join(words)


def magnet_size(design: Design) -> str:
    """Diameter and height of the magnets."""
    return f"⌀ {design.parameters.magnet_mm:g} × {design.parameters.magnet_height_mm:g} mm"


def end_in_words(design: Design, end: HingeEnd) -> str:
    """The hinge at one end of a piece."""
    if end.kind == "open":
        return "free"
    if design.placement is not None:
        return f"{'pin' if end.captive else 'socket'}, in place"
    return f"{end.kind}, {end.role}"

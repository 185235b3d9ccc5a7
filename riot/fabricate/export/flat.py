"""Flat files: what a laser cuts, as SVG and DXF at true size in millimetres, sheet by sheet. Ours.

Three kinds: bare outlines; the strips of cloth or tape that join these; and the two layers of every piece with
knuckles and pin holes, to be stacked, glued and pinned. Besides, a test piece.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from riot.errors import RiotError
from riot.fabricate.export.flat_parts import KINDS, FlatPart, Kind, flat_parts
from riot.fabricate.export.laser_coupon import laser_coupon
from riot.fabricate.export.laser_sheet import LaserSheet, dxf_bytes, laser_sheets, sheets_by_kerf, svg_bytes
from riot.fabricate.export.tray_sheet import tray_flat_parts
from riot.fabricate.model import Design
from riot.fabricate.solid import Part

LASER_FORMATS = (".svg", ".dxf")
COUPON = "laser-coupon"


class FlatFormatError(RiotError, ValueError):
    """A file name whose suffix is no format for lasers."""


def laser_kinds(design: Design) -> tuple[Kind, ...]:
    """The kinds that a design can be made of: hinges that are no flat knuckles leave bare outlines and strips."""
    return tuple(kind for kind in KINDS if kind != "layers" or design.stackable)


def laser_notes(design: Design) -> list[str]:
    """What a laser cannot make of a design, in words.

    A telescopic hinge lifts its piece; neither stacked layers nor a strip do.
    """
    if design.placement is not None:
        return [
            "laser files: no layers with knuckles, because pins in their sockets are printed in place: cut the "
            "outlines, or choose another pivot"
        ]
    if design.telescope is None:
        slots = (
            "laser files: pockets of magnets are slots through both layers of a piece: glue magnets in at half height"
        )
        return [slots] if design.parameters.magnet_mm else []
    hinges = ", ".join(str(hinge + 1) for hinge in design.motion.lifted)
    return [
        f"laser files: no layers with knuckles, because the hinges before the pieces {hinges} must lift (telescopic "
        "hinges), which stacked sheets cannot: cut the outlines, leave these hinges without a strip, and lift there by "
        "hand, or print the puzzle"
    ]


def write_flat(design: Design, path: str | os.PathLike[str], kind: Kind = "outlines", *, kerf: bool = False) -> None:
    """Write the parts of one kind for a laser; the suffix (svg, dxf) chooses the format.

    Parts are nested into sheets of the bed's size. One sheet has the name that is given, several have a number each
    before the suffix. With ``kerf`` the laser's path is half the kerf outside the parts (inside the holes), so that
    they come out at nominal size. Every part is one closed path, and so is every hole; holes are before outlines. The
    same design gives the same bytes.

    Raises
    ------
    FlatFormatError
        For another suffix.
    riot.errors.MissingExtraError
        If a DXF file is asked for and ezdxf is not installed.
    riot.errors.FabricationError
        ``telescopic``: layers of a design with telescopic hinges, which cannot be stacked from sheets; ``bed``: a part
        is larger than the bed.
    """
    target = Path(path)
    if target.suffix.lower() not in LASER_FORMATS:
        raise FlatFormatError(f"cannot write {target.name!r} for a laser: use a file name that ends in .svg or .dxf")
    sheets = laser_sheets(flat_parts(design, kind), design.parameters, kerf=kerf)
    _write(sheets, target.with_suffix(""), [target.suffix.lower()], _title(design, kind, kerf))


def write_flat_files(design: Design, folder: Path, *, dxf: bool = True, trays: tuple[Part, ...] = ()) -> list[Path]:
    """Write all flat files into a folder that exists: ``laser-outlines.svg``, ``laser-outlines-kerf.svg`` and so on.

    ``laser-coupon.svg`` is the test piece. `laser_kinds` are the kinds; ``trays`` come besides. Errors as `write_flat`.
    """
    suffixes = LASER_FORMATS if dxf else LASER_FORMATS[:1]
    written = []
    kinds: dict[str, list[FlatPart]] = {kind: flat_parts(design, kind) for kind in laser_kinds(design)}
    if trays:
        kinds["trays"] = tray_flat_parts(design, trays)
    for kind, parts in kinds.items():
        for kerf, sheets in enumerate(sheets_by_kerf(parts, design.parameters)):
            stem = folder / f"laser-{kind}{'-kerf' if kerf else ''}"
            written += _write(sheets, stem, suffixes, _title(design, kind, bool(kerf)))
    coupon = laser_sheets(laser_coupon(design.parameters), design.parameters)
    return [*written, *_write(coupon, folder / COUPON, suffixes, "kerf and fit of the pin, a test piece")]


def _title(design: Design, kind: str, kerf: bool) -> str:
    names = f"{design.transform.p.name or 'P'} and {design.transform.q.name or 'Q'}"
    material = "cloth or tape" if kind == "strips" else f"{design.parameters.sheet_mm:g} mm thick"
    return f"{names}, {kind}, {material}{f', kerf {design.parameters.kerf_mm:g} mm' if kerf else ''}"


def _write(sheets: Sequence[LaserSheet], stem: Path, suffixes: Sequence[str], title: str) -> list[Path]:
    written = []
    for number, sheet in enumerate(sheets, start=1):
        for suffix in suffixes:
            name = f"{stem.name}-{number}" if len(sheets) > 1 else stem.name
            written.append(stem.with_name(f"{name}{suffix}"))
            words = f"{title}, sheet {number} of {len(sheets)}"
            written[-1].write_bytes(svg_bytes(sheet, words) if suffix == ".svg" else dxf_bytes(sheet))
    return written

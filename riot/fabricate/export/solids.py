"""The files of a puzzle: an STL a part, 3MF plates, a list of parts; the same bytes every time. Ours."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from riot.draw.palette import PIECES, hue
from riot.errors import FabricationError
from riot.fabricate.certificate import FabricationCertificate
from riot.fabricate.export.drawing import Drawing, drawing_of
from riot.fabricate.export.folder import PUZZLE_FILES, new_folder
from riot.fabricate.export.inlay import Body, bodies_of, chain_bodies
from riot.fabricate.export.plate_file import DIGITS, plate_bytes
from riot.fabricate.export.stl import stl_bytes
from riot.fabricate.in_place import chain_part
from riot.fabricate.model import Design
from riot.fabricate.plates import Plate, lay_out
from riot.fabricate.solid import Part
from riot.fabricate.tray import check_tray

FORMAT, VERSION = "riot-parts", 1


def write_puzzle(
    design: Design,
    parts: tuple[Part, ...],
    certificate: FabricationCertificate,
    folder: Path,
    more: Sequence[Callable[[Path], None]] = (),
    *,
    trays: tuple[Part, ...] = (),
    drawing: Drawing | None = None,
    replace_files: bool = False,
) -> list[Path]:
    """Write all files of a puzzle into a new folder, or none: ``NAME.stl`` a part, ``plate-K.3mf``, ``parts.json``.

    If the parameters ask for inlays, every piece is several bodies on its plate, and ``NAME-base.stl``,
    ``NAME-front-2.stl`` and so on besides, the number that of the filament: by default with lines
    along the outlines, or with another ``drawing``. Each of ``more`` writes further files into the folder it is given.
    What is printed in place is one part, ``chain.stl``. ``trays`` (`riot.fabricate.tray`) come besides.
    Returns what was written.

    Raises `riot.errors.FabricationError` if the certificate fails or a part does not fit the bed, OSError if
    the folder cannot be written, is a file, or holds something already that ``replace_files`` does not allow to replace
    (`riot.fabricate.export.folder.new_folder`).
    """
    if not certificate.passed:
        raise FabricationError("uncertified", "; ".join(certificate.failures))
    printed = (*(parts if design.placement is None else (chain_part(design, parts),)), *trays)
    plates = lay_out(printed, design.parameters)
    title = f"{design.transform.p.name} – {design.transform.q.name}"
    colours = {piece.name: PIECES[hue(piece.index, len(design.pieces))] for piece in design.pieces}
    drawing = drawing or drawing_of(design)
    bodies = {} if drawing is None else {part.name: bodies_of(design, part, drawing) for part in parts}
    if design.placement is not None:
        bodies["chain"] = chain_bodies(design, parts, bodies)
    with new_folder(folder, replace_files=replace_files, stale=PUZZLE_FILES) as temporary:
        for part in printed:
            (temporary / f"{part.name}.stl").write_bytes(stl_bytes(part))
            for body in bodies.get(part.name, ()) if drawing is not None else ():
                (temporary / f"{part.name}-{body.name}.stl").write_bytes(stl_bytes(body))
        for k, plate in enumerate(plates):
            (temporary / f"plate-{k + 1}.3mf").write_bytes(plate_bytes(plate, printed, title, colours, bodies))
        record = parts_document(design, (*parts, *trays), certificate, plates, bodies)
        document = json.dumps(record, indent=1, ensure_ascii=False)
        (temporary / "parts.json").write_text(f"{document}\n", encoding="utf-8", newline="\n")
        for write in more:
            write(temporary)
        names = [path.relative_to(temporary) for path in temporary.rglob("*") if path.is_file()]
    return sorted(folder / name for name in names)


def parts_document(
    design: Design,
    parts: tuple[Part, ...],
    certificate: FabricationCertificate,
    plates: tuple[Plate, ...],
    bodies: Mapping[str, Sequence[Body]] | None = None,
) -> dict[str, Any]:
    """What ``parts.json`` holds: parts with sizes, volumes and counts, plates, parameters, certificate, warnings."""
    return {
        "format": FORMAT,
        "version": VERSION,
        "p": design.transform.p.name,
        "q": design.transform.q.name,
        "mm_per_unit": design.scale,
        "parameters": asdict(design.parameters),
        "motion": design.motion.words,
        "open_hinge": design.motion.open_hinge,
        "parts": [
            {
                "name": part.name,
                "kind": part.kind,
                "count": part.count,
                "printed": "in place"
                if _in_chain(design, part)
                else "upside down"
                if part.upside_down
                else "as it lies",
                "file": f"{'chain' if _in_chain(design, part) else part.name}.stl",
                "size_mm": [round(length, DIGITS) for length in part.size],
                "volume_mm3": round(part.volume, DIGITS),
                "bodies": [
                    {
                        "name": body.name,
                        "filament": body.filament,
                        "colour": body.colour,
                        "file": f"{'chain-' if design.placement else ''}{part.name}-{body.name}.stl",
                        "volume_mm3": round(body.volume, DIGITS),
                    }
                    for body in (bodies or {}).get(part.name, ())
                ],
            }
            for part in parts
        ],
        "hinges": [
            {"hinge": piece.start.hinge, "kind": piece.start.kind, "joins": [design.pieces[i - 1].name, piece.name]}
            for i, piece in enumerate(design.pieces)
        ],
        "pins": [asdict(pin) for pin in design.pins],
        "placement": None if design.placement is None else asdict(design.placement),
        "magnets": [
            {"piece": piece.name, "shape": pocket.side, "x": pocket.x, "y": pocket.y, "pole": pocket.pole}
            for piece in design.pieces
            for pocket in piece.pockets
        ],
        "plates": [
            {"file": f"plate-{k + 1}.3mf", "parts": [item.name for item in plate]} for k, plate in enumerate(plates)
        ],
        "certificate": {
            "passed": certificate.passed,
            "gap_mm": _finite(certificate.motion.gap),
            "gap_proven_mm": certificate.motion.floor if certificate.motion.proven else None,
            "narrowest_mm": round(certificate.wall, 3),
            "hinge_share": round(certificate.hinge_share, 4),
            "overhang_degrees": round(certificate.overhang, 1),
            "bridge_mm": round(certificate.bridge, 2),
            "overlap_mm3": certificate.motion.overlap,
            "poses": certificate.motion.poses,
            "hinges": [{**_finites(asdict(check)), "failures": list(check.failures)} for check in certificate.hinges],
            "placement": None if certificate.placement is None else _finites(asdict(certificate.placement)),
            "trays": [_finites(asdict(check_tray(design, part))) for part in parts if part.kind == "tray"],
            "magnets": [_finites(asdict(check)) for check in certificate.magnets],
        },
        "warnings": list(design.warnings),
    }


def _in_chain(design: Design, part: Part) -> bool:
    """Whether a part is printed in place, as one of a chain."""
    return design.placement is not None and part.kind == "piece"


def _finites(values: dict[str, Any]) -> dict[str, Any]:
    """A record without numbers that JSON does not have."""
    return {key: _finite(value) if isinstance(value, float) else value for key, value in values.items()}


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None

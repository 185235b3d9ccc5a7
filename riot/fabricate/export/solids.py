"""The files of a puzzle: an STL a part, 3MF plates, a list of parts; the same bytes every time. Ours."""

from __future__ import annotations

import io
import json
import math
import struct
import zipfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np

from riot.draw.palette import PIECES, hue
from riot.errors import FabricationError
from riot.fabricate.certificate import FabricationCertificate
from riot.fabricate.export.folder import PUZZLE_FILES, new_folder
from riot.fabricate.model import Design
from riot.fabricate.plates import PlacedPart, Plate, lay_out
from riot.fabricate.solid import Part

FORMAT, VERSION = "riot-parts", 1

DIGITS = 6
"""Decimals of a millimetre in 3MF files."""

_CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
_TYPES = (
    '<?xml version="1.0" encoding="UTF-8"?>\n'
    '<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">'
    '<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
    '<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>'
    "</Types>\n"
)
_RELATIONS = (
    '<?xml version="1.0" encoding="UTF-8"?>\n'
    '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
    '<Relationship Target="/3D/3dmodel.model" Id="rel0" '
    'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>'
    "</Relationships>\n"
)
_GREY = "#9aa3ad"
_EPOCH = (1980, 1, 1, 0, 0, 0)


def write_puzzle(
    design: Design,
    parts: tuple[Part, ...],
    certificate: FabricationCertificate,
    folder: Path,
    more: Sequence[Callable[[Path], None]] = (),
    *,
    replace_files: bool = False,
) -> list[Path]:
    """Write all files of a puzzle into a new folder, or none: ``NAME.stl`` a part, ``plate-K.3mf``, ``parts.json``.

    Each of ``more`` writes further files into the folder that it is given. Returns what was written.

    Raises `riot.errors.FabricationError` if the certificate fails or a part does not fit the bed, OSError if
    the folder cannot be written, is a file, or holds something already that ``replace_files`` does not allow to replace
    (`riot.fabricate.export.folder.new_folder`).
    """
    if not certificate.passed:
        raise FabricationError("uncertified", "; ".join(certificate.failures))
    plates = lay_out(parts, design.parameters)
    title = f"{design.transform.p.name} – {design.transform.q.name}"
    colours = {piece.name: PIECES[hue(piece.index, len(design.pieces))] for piece in design.pieces}
    with new_folder(folder, replace_files=replace_files, stale=PUZZLE_FILES) as temporary:
        for part in parts:
            (temporary / f"{part.name}.stl").write_bytes(stl_bytes(part))
        for k, plate in enumerate(plates):
            (temporary / f"plate-{k + 1}.3mf").write_bytes(plate_bytes(plate, parts, title, colours))
        document = json.dumps(parts_document(design, parts, certificate, plates), indent=1, ensure_ascii=False)
        (temporary / "parts.json").write_text(f"{document}\n", encoding="utf-8", newline="\n")
        for write in more:
            write(temporary)
        names = [path.relative_to(temporary) for path in temporary.rglob("*") if path.is_file()]
    return sorted(folder / name for name in names)


def stl_bytes(part: Part) -> bytes:
    """A part as binary STL, mm; coordinates are rounded to 32 bits."""
    points, triangles = part.mesh()
    corners = points.astype("<f4")[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]).astype(np.float64)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    record = np.zeros(len(triangles), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    record["normal"] = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0.0)
    record["corners"] = corners
    header = f"riot {part.name}, mm".encode("ascii").ljust(80, b" ")
    return header + struct.pack("<I", len(triangles)) + record.tobytes()


def plate_bytes(plate: Plate, parts: tuple[Part, ...], title: str, colours: Mapping[str, str]) -> bytes:
    """A plate as 3MF: every part that lies on it as a named object with its colour, and where it lies, uncompressed.

    ``colours`` (``#rrggbb`` by name) become base materials; what has none is grey.
    """
    named = {part.name: part for part in parts}
    used = [part for part in parts if any(item.name == part.name for item in plate)]
    ids = {part.name: k + 1 for k, part in enumerate(used)}
    materials = f'pid="{len(used) + 1}" pindex="{{}}"'
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<model unit="millimeter" xml:lang="en-US" xmlns="{_CORE}">',
        f'<metadata name="Title">{quoteattr(title)[1:-1]}</metadata>',
        '<metadata name="Application">riot</metadata>',
        "<resources>",
        f'<basematerials id="{len(used) + 1}">',
        *(
            f'<base name={quoteattr(part.name)} displaycolor="{colours.get(part.name, _GREY).upper()}"/>'
            for part in used
        ),
        "</basematerials>",
    ]
    for k, part in enumerate(used):
        points, triangles = part.mesh()
        lines.append(f'<object id="{ids[part.name]}" type="model" name={quoteattr(part.name)} {materials.format(k)}>')
        lines.append("<mesh><vertices>")
        lines += [f'<vertex x="{_number(x)}" y="{_number(y)}" z="{_number(z)}"/>' for x, y, z in points.tolist()]
        lines.append("</vertices><triangles>")
        lines += [f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in triangles.tolist()]
        lines.append("</triangles></mesh></object>")
    lines.append("</resources><build>")
    for item in plate:
        numbers = " ".join(_number(value) for value in _placement(item, named[item.name]))
        label = quoteattr(f"{item.name}" if named[item.name].count == 1 else f"{item.name}-{item.number + 1}")
        lines.append(f'<item objectid="{ids[item.name]}" transform="{numbers}" partnumber={label}/>')
    lines += ["</build>", "</model>", ""]
    held = io.BytesIO()
    with zipfile.ZipFile(held, "w", zipfile.ZIP_STORED) as archive:
        for name, text in (
            ("[Content_Types].xml", _TYPES),
            ("_rels/.rels", _RELATIONS),
            ("3D/3dmodel.model", "\n".join(lines)),
        ):
            entry = zipfile.ZipInfo(name, _EPOCH)
            entry.create_system, entry.external_attr = 3, 0o644 << 16
            archive.writestr(entry, text.encode("utf-8"))
    return held.getvalue()


def _placement(item: PlacedPart, part: Part) -> list[float]:
    """The twelve numbers of a 3MF transform, row vectors times matrix: a quarter turn or none, then a shift."""
    box = part.printed.bounding_box()
    if item.turned:  # (x, y) goes to (−y, x)
        return [0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0, item.x + box[4], item.y - box[0], -box[2]]
    return [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, item.x - box[0], item.y - box[1], -box[2]]


def _number(value: float) -> str:
    """A decimal number without an exponent, without a minus zero."""
    digits = f"{value:.{DIGITS}f}".rstrip("0").rstrip(".")
    return "0" if digits in ("-0", "") else digits


def parts_document(
    design: Design, parts: tuple[Part, ...], certificate: FabricationCertificate, plates: tuple[Plate, ...]
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
                "printed": "upside down" if part.upside_down else "as it lies",
                "file": f"{part.name}.stl",
                "size_mm": [round(length, DIGITS) for length in part.size],
                "volume_mm3": round(part.volume, DIGITS),
            }
            for part in parts
        ],
        "hinges": [
            {"hinge": piece.start.hinge, "kind": piece.start.kind, "joins": [design.pieces[i - 1].name, piece.name]}
            for i, piece in enumerate(design.pieces)
        ],
        "pins": [asdict(pin) for pin in design.pins],
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
            "hinges": [{**asdict(check), "failures": list(check.failures)} for check in certificate.hinges],
        },
        "warnings": list(design.warnings),
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None

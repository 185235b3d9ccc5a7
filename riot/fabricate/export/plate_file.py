"""Plates as 3MF: parts with their colours, where they lie on the bed; bodies of several filaments. Ours.

A part of several bodies is one object: a closed shell of triangles a body, each triangle with its body's material (3MF
Core Specification 1.3, "Triangle properties"). PrusaSlicer drops components of an object to the bed one by one, and so
bodies are no components; which triangles are a body, and its filament, it reads from ``Slic3r_PE_model.config``.
"""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from xml.sax.saxutils import quoteattr

from riot.fabricate.export.inlay import Body
from riot.fabricate.plates import PlacedPart, Plate
from riot.fabricate.solid import Part
from riot.types import FloatArray, IntArray

DIGITS = 6
"""Decimals of a millimetre in 3MF files."""

CONFIG = "Metadata/Slic3r_PE_model.config"
_SPACE = ' xmlns:slic3rpe="http://schemas.slic3r.org/3mf/2017/06"'
_BODIES_LIE_WHERE_THEY_ARE = '<metadata name="slic3rpe:Version3mf">1</metadata>'
"""Without it PrusaSlicer moves every body but the first."""


_CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
_TYPES = (
    '<?xml version="1.0" encoding="UTF-8"?>\n'
    '<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">'
    '<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
    '<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>'
    '<Default Extension="config" ContentType="text/xml"/>'
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

Mesh = tuple[FloatArray, IntArray]
"""Points and triangles."""

Material = tuple[str, str]
"""Its name, and its colour as ``#rrggbb``."""


def plate_bytes(
    plate: Plate,
    parts: Sequence[Part],
    title: str,
    colours: Mapping[str, str],
    bodies: Mapping[str, Sequence[Body]] | None = None,
) -> bytes:
    """A plate as 3MF: every part that lies on it as a named object with its colour, and where it lies, uncompressed.

    ``colours`` (``#rrggbb`` by name) become base materials; what has none is grey. ``bodies`` are those of parts that
    have several filaments, by name.
    """
    named = {part.name: part for part in parts}
    used = [part for part in parts if any(item.name == part.name for item in plate)]
    ids = {part.name: k + 1 for k, part in enumerate(used)}
    made_of = {part.name: (bodies or {}).get(part.name, ()) for part in used}
    alone = {part.name: (part.name, colours.get(part.name, _GREY)) for part in used if not made_of[part.name]}
    materials = list(dict.fromkeys([*alone.values(), *(_material(body) for name in made_of for body in made_of[name])]))
    group, parted = len(used) + 1, any(made_of.values())
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<model unit="millimeter" xml:lang="en-US" xmlns="{_CORE}"{_SPACE if parted else ""}>',
        f'<metadata name="Title">{quoteattr(title)[1:-1]}</metadata>',
        '<metadata name="Application">riot</metadata>',
        *([_BODIES_LIE_WHERE_THEY_ARE] if parted else []),
        "<resources>",
        f'<basematerials id="{group}">',
        *(f'<base name={quoteattr(name)} displaycolor="{colour.upper()}"/>' for name, colour in materials),
        "</basematerials>",
    ]
    for part in used:
        shells = [(body.mesh(), materials.index(_material(body))) for body in made_of[part.name]]
        shells = shells or [(part.mesh(), materials.index(alone[part.name]))]
        lines += _object(ids[part.name], part.name, group, shells)
    lines.append("</resources><build>")
    for item in plate:
        numbers = " ".join(_number(value) for value in _placement(item, named[item.name]))
        label = quoteattr(f"{item.name}" if named[item.name].count == 1 else f"{item.name}-{item.number + 1}")
        lines.append(f'<item objectid="{ids[item.name]}" transform="{numbers}" partnumber={label}/>')
    files = {
        "[Content_Types].xml": _TYPES,
        "_rels/.rels": _RELATIONS,
        "3D/3dmodel.model": "\n".join([*lines, "</build>", "</model>", ""]),
    }
    if parted:
        files[CONFIG] = "\n".join(_config(ids, made_of))
    return _archive(files)


def _material(body: Body) -> Material:
    return f"filament {body.filament}", body.colour


def _object(number: int, name: str, group: int, shells: Sequence[tuple[Mesh, int]]) -> Iterator[str]:
    """An object of closed shells, each of a material of the group; the first's is that of the object."""
    yield f'<object id="{number}" type="model" name={quoteattr(name)} pid="{group}" pindex="{shells[0][1]}">'
    yield "<mesh><vertices>"
    for (points, _), _ in shells:
        yield from (f'<vertex x="{_number(x)}" y="{_number(y)}" z="{_number(z)}"/>' for x, y, z in points.tolist())
    yield "</vertices><triangles>"
    first = 0
    for (points, triangles), material in shells:
        own = "" if material == shells[0][1] else f' pid="{group}" p1="{material}"'
        yield from (f'<triangle v1="{a}" v2="{b}" v3="{c}"{own}/>' for a, b, c in (triangles + first).tolist())
        first += len(points)
    yield "</triangles></mesh></object>"


def _config(ids: Mapping[str, int], made_of: Mapping[str, Sequence[Body]]) -> Iterator[str]:
    """Which triangles are a body, and its filament."""
    yield '<?xml version="1.0" encoding="UTF-8"?>'
    yield "<config>"
    for name, bodies in made_of.items():
        if not bodies:
            continue
        yield f'<object id="{ids[name]}"><metadata type="object" key="name" value={quoteattr(name)}/>'
        first = 0
        for body in bodies:
            last = first + len(body.mesh()[1]) - 1
            yield f'<volume firstid="{first}" lastid="{last}">'
            yield f'<metadata type="volume" key="name" value={quoteattr(body.name)}/>'
            yield f'<metadata type="volume" key="extruder" value="{body.filament}"/></volume>'
            first = last + 1
        yield "</object>"
    yield "</config>\n"


def _archive(files: Mapping[str, str]) -> bytes:
    held = io.BytesIO()
    with zipfile.ZipFile(held, "w", zipfile.ZIP_STORED) as archive:
        for name, text in files.items():
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

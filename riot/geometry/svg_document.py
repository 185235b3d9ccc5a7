"""SVG file → XML tree that is safe to draw, with nothing in it that the renderer is known to draw differently (ours).

Whatever names another file, grows without bound (entities), or is not drawn as browsers do is refused with its reason.
"""

from __future__ import annotations

import os
import re
import zlib
from pathlib import Path
from xml.etree import ElementTree
from xml.parsers import expat

from riot.errors import SilhouetteError
from riot.geometry.limits import SVG_BYTES, TooManyBytes, read_bytes
from riot.geometry.machine_errors import is_of_machine
from riot.geometry.svg_page import NAMESPACE
from riot.geometry.svg_style import unsupported_attributes, unsupported_sheet

_MAX_ELEMENTS = 100_000
"""Greatest number of elements of a file. Ours: it bounds the time."""

_MAX_DEPTH = 200
"""Greatest depth of elements in each other. Ours: drawings by hand are a few deep."""

_MAX_STYLE = 30_000
"""Greatest length of all style sheets together, characters. Ours: time grows with the square."""

_MAX_ATTRIBUTE = 10_000
"""Greatest length of an attribute that is no path, characters. Ours, for the same reason."""

_GZIP = b"\x1f\x8b"
_WITH_A_GZIP_HEADER = 31
_BLANK = b"\xef\xbb\xbf\xff\xfe \t\r\n"
"""Byte-order marks and white space, which may precede the XML."""

HEAD_BYTES = 4096
"""Bytes that are read to tell an SVG file from a picture. Ours."""

_HEAD = re.compile(rb"<(?:\?xml|!--|!DOCTYPE|(?:[\w.-]+:)?svg\b)")

_HREFS = ("href", "{http://www.w3.org/1999/xlink}href")
_OTHER_FILE = re.compile(r"@import|url\(\s*['\"]?\s*(?!['\"]?\s*#)", re.IGNORECASE)
_IGNORED = ("script", "title", "desc", "metadata", "font", "view", "cursor", "audio", "video", "iframe", "canvas")
_NOT_DRAWN = {
    "text": "has text, which looks different on every machine; turn it into paths, or delete it",
    "image": "has an embedded picture; read that picture itself, or export the drawing as PNG",
    "feImage": "has a picture in a filter; export the drawing as PNG",
    "foreignObject": "has content that is no SVG (foreignObject); export the drawing as PNG",
    **dict.fromkeys(
        ("animate", "animateTransform", "animateMotion", "animateColor", "set"),
        "is animated; delete the animation, or export one picture of it as PNG",
    ),
}
"""What browsers draw and the renderer does not, or not on every machine alike; what to do."""


def begins_like_svg(head: bytes) -> bool:
    """Whether the first bytes of a file, perhaps compressed, are those of XML.

    >>> begins_like_svg(b"  <ns0:svg"), begins_like_svg(b"GIF89a")
    (True, False)
    """
    if head.startswith(_GZIP):
        try:
            head = zlib.decompressobj(_WITH_A_GZIP_HEADER).decompress(head, HEAD_BYTES)
        except zlib.error:
            return False
    return _HEAD.match(head.replace(b"\0", b"").lstrip(_BLANK)) is not None  # UTF-16 has zeros


def load(path: str | os.PathLike[str]) -> ElementTree.Element:
    """Parse an SVG file, which may be compressed (.svgz).

    Raises
    ------
    SilhouetteError
        ``unreadable``, ``too-large``, ``unsupported``.
    OSError
        The machine failed (`riot.geometry.machine_errors`): nothing is known of the file.

    >>> from pathlib import Path
    >>> _ = Path("square.svg").write_text('<svg xmlns="http://www.w3.org/2000/svg"><path d="M0 0H9V9H0z"/></svg>')
    >>> len(load("square.svg"))
    1
    """
    where = Path(path)
    try:
        data = _uncompressed(read_bytes(where, SVG_BYTES)).lstrip(b" \t\r\n")
    except TooManyBytes as error:
        raise SilhouetteError("too-large", f"{where}: {error}; simplify the file") from error
    except (OSError, ValueError) as error:  # ValueError: a path with a null character
        if is_of_machine(error):
            raise
        reason = getattr(error, "strerror", error)
        raise SilhouetteError("unreadable", f"{where}: cannot be read ({reason}); check the path") from error
    except zlib.error as error:
        raise SilhouetteError(
            "unreadable", f"{where}: compressed data is damaged ({error}); restore the file or save it again"
        ) from error
    try:
        _refuse_declarations(data, where)
        root = ElementTree.fromstring(data)
    except (expat.ExpatError, ElementTree.ParseError, ValueError, LookupError, RecursionError) as error:
        if isinstance(error, SilhouetteError):
            raise
        raise SilhouetteError(
            "unreadable",
            f"{where}: not well-formed XML ({error}); save the drawing again, or export it as PNG",
        ) from error
    if tag_of(root) != "svg":
        raise SilhouetteError(
            "unreadable", f"{where}: the XML is no SVG (its root is <{tag_of(root)}>); export the drawing as SVG or PNG"
        )
    _refuse_large(root, where)
    _keep_drawn(root)
    _refuse_other_files(root, where)
    _refuse_not_drawn(root, where)
    return root


def tag_of(element: ElementTree.Element) -> str:
    """An element's name without its namespace.

    >>> tag_of(ElementTree.fromstring('<path xmlns="http://www.w3.org/2000/svg"/>'))
    'path'
    """
    return str(element.tag).rpartition("}")[2]


def _uncompressed(data: bytes) -> bytes:
    if not data.startswith(_GZIP):
        return data
    text = zlib.decompressobj(_WITH_A_GZIP_HEADER).decompress(data, SVG_BYTES + 1)
    if len(text) > SVG_BYTES:
        raise TooManyBytes(f"uncompressed, more bytes than the limit of {SVG_BYTES}")
    return text


def _refuse_declarations(data: bytes, where: Path) -> None:
    """Refuse entities, which can grow without bound or name files of this machine; a DOCTYPE alone is harmless."""

    def doctype(name: str, system: str | None, public: str | None, internal: bool) -> None:
        if internal:
            raise SilhouetteError(
                "unsupported",
                f"{where}: the DOCTYPE declares entities; delete it (<!DOCTYPE …]>) or save as plain SVG",
            )

    def instruction(target: str, _: str) -> None:
        if target == "xml-stylesheet":
            raise SilhouetteError("unsupported", f"{where}: the style sheet is another file; embed it, or save as PNG")

    parser = expat.ParserCreate()
    parser.StartDoctypeDeclHandler = doctype
    parser.ProcessingInstructionHandler = instruction
    parser.Parse(data, True)


def _refuse_large(root: ElementTree.Element, where: Path) -> None:
    depth, level, count = 0, [root], 0
    style = sum(len(element.text or "") for element in root.iter() if tag_of(element) == "style")
    while level and depth <= _MAX_DEPTH:
        depth, count = depth + 1, count + len(level)
        level = [child for parent in level for child in parent]
    long = [
        name
        for element in root.iter()
        for name, value in element.attrib.items()
        if len(value) > _MAX_ATTRIBUTE and name not in ("d", "points") and not _space(name)
    ]
    for too_large, what in (
        (depth > _MAX_DEPTH, f"elements are nested more than {_MAX_DEPTH} deep"),
        (count > _MAX_ELEMENTS, f"more than {_MAX_ELEMENTS} elements"),
        (style > _MAX_STYLE, f"style sheets have more than {_MAX_STYLE} characters"),
        (bool(long), f"{(*long, '')[0]} has more than {_MAX_ATTRIBUTE} characters"),
    ):
        if too_large:
            raise SilhouetteError("too-large", f"{where}: {what}; save as plain SVG, or simplify the drawing")


def _keep_drawn(root: ElementTree.Element) -> None:
    """Take out what is never drawn and what editors keep under names of their own."""
    bare = not _space(root.tag)  # without a namespace it is no SVG for a browser, but was meant as one
    for parent in list(root.iter()):
        if bare and not _space(parent.tag):
            parent.tag = f"{{{NAMESPACE}}}{parent.tag}"
        for child in list(parent):
            if tag_of(child) in _IGNORED or _space(child.tag) != ("" if bare else NAMESPACE):
                parent.remove(child)
        for name, value in list(parent.attrib.items()):
            empty = not value.strip() or (name in ("rx", "ry") and value.strip() == "auto")
            if empty or name == "requiredFeatures" or (_space(name) and name not in _HREFS):
                del parent.attrib[name]


def _refuse_other_files(root: ElementTree.Element, where: Path) -> None:
    for element in root.iter():
        tag = tag_of(element)
        texts = [element.text or ""] if tag == "style" else []
        texts += [value for value in element.attrib.values() if "(" in value]
        links = [element.attrib[key].strip() for key in _HREFS if key in element.attrib and tag not in ("a", "image")]
        outside = [link for link in links if not link.startswith("#")]
        outside += [text for text in texts if _OTHER_FILE.search(text)]
        if outside:
            raise SilhouetteError(
                "unsupported", f"{where}: <{tag}> refers to another file ({outside[0][:60]!r}); embed or delete it"
            )


def _refuse_not_drawn(root: ElementTree.Element, where: Path) -> None:
    filters = {f"url(#{element.get('id')})" for element in root.iter() if tag_of(element) == "filter"}
    for element in root.iter():
        tag = tag_of(element)
        if element.get("filter", "none").startswith("url") and element.get("filter") not in filters:
            raise SilhouetteError("unsupported", f"{where}: <{tag}> names a filter that is not there; delete the name")
        reason = _NOT_DRAWN.get(tag)
        if (tag == "text" and not "".join(element.itertext()).strip()) or _needs_an_extension(element):
            reason = None
        if reason is not None:
            raise SilhouetteError("unsupported", f"{where}: the drawing {reason}")
        lacking = unsupported_sheet(element) if tag == "style" else unsupported_attributes(element, element is root)
        if lacking is not None:
            raise SilhouetteError(
                "unsupported",
                f"{where}: <{tag}> uses {lacking}, which is not drawn as in a browser; save as plain SVG 1.1 with "
                "attributes in place of CSS, or export as PNG",
            )


def _needs_an_extension(element: ElementTree.Element) -> bool:
    return bool(element.get("requiredExtensions", "").strip())


def _space(name: str) -> str:
    return str(name).rpartition("}")[0].removeprefix("{")

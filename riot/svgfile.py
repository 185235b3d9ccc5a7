"""SVG file → XML tree that is safe and simple to draw: no declarations, no other files, no hidden content drawn."""

from __future__ import annotations

import os
import re
from pathlib import Path
from xml.etree import ElementTree
from xml.parsers import expat

from riot.errors import SilhouetteError

NAMESPACE = "http://www.w3.org/2000/svg"

_MAX_BYTES = 20_000_000
_MAX_DRAWN = 100_000
"""Elements that may be drawn after all ``<use>`` references are followed."""

_HREFS = ("href", "{http://www.w3.org/1999/xlink}href")
_NOT_DRAWN = ("symbol", "mask", "marker", "clipPath", "pattern", "filter", "linearGradient", "radialGradient")
_OTHER_FILE = re.compile(r"@import|url\(\s*['\"]?\s*(?!['\"]?\s*#)", re.IGNORECASE)


def load(path: str | os.PathLike[str]) -> ElementTree.Element:
    """Parse an SVG file; what is only drawn by reference (symbols, masks …) is moved into ``<defs>``.

    Raises
    ------
    SilhouetteError
        ``unreadable``, ``too-large``, ``unsupported``.
    """
    where = Path(path)
    try:
        size = where.stat().st_size
        if size > _MAX_BYTES:
            raise SilhouetteError("too-large", f"{where}: {size} bytes are more than {_MAX_BYTES}; simplify the file")
        data = where.read_bytes()
    except (OSError, ValueError) as error:  # ValueError: a path with a null character; ours is one, too
        if isinstance(error, SilhouetteError):
            raise
        said = getattr(error, "strerror", error)
        raise SilhouetteError("unreadable", f"{where}: cannot be read ({said}); check the path") from error
    try:
        _refuse_declarations(data, where)
        root = ElementTree.fromstring(data)
    except (expat.ExpatError, ElementTree.ParseError, ValueError, LookupError, RecursionError) as error:
        if isinstance(error, SilhouetteError):
            raise
        raise SilhouetteError(
            "unreadable",
            f"{where}: not well-formed XML ({error}); save the file again (a picture is read by Shape.from_image)",
        ) from error
    if _tag(root) != "svg":
        raise SilhouetteError(
            "unreadable", f"{where}: the XML is no SVG (its root is <{_tag(root)}>); export the drawing as SVG or PNG"
        )
    _refuse_references(root, where)
    _refuse_explosions(root, where)
    _refuse_clipping(root, where)
    _hide(root)
    return root


def _refuse_declarations(data: bytes, where: Path) -> None:
    # Before anything else parses the file: entities can grow without bound or name files of this machine.
    def refuse(*_: object) -> None:
        raise SilhouetteError(
            "unsupported", f"{where}: the file has a DOCTYPE declaration; delete it (<!DOCTYPE …>) or save as plain SVG"
        )

    parser = expat.ParserCreate()
    parser.StartDoctypeDeclHandler = refuse
    parser.EntityDeclHandler = refuse
    parser.Parse(data, True)


def _refuse_references(root: ElementTree.Element, where: Path) -> None:
    for element in root.iter():
        tag = _tag(element)
        texts = [element.text or ""] if tag == "style" else []
        texts += [value for key, value in element.attrib.items() if "(" in value]
        links = [element.attrib[key].strip() for key in _HREFS if key in element.attrib and tag != "a"]
        outside = [link for link in links if not link.startswith(("#", "data:"))]
        outside += [text for text in texts if _OTHER_FILE.search(text)]
        if outside:
            raise SilhouetteError(
                "unsupported", f"{where}: <{tag}> refers to another file ({outside[0][:60]!r}); embed or delete it"
            )


def _refuse_explosions(root: ElementTree.Element, where: Path) -> None:
    """Count what ``<use>`` would draw: a few nested references can ask for billions of elements."""
    named = {element.attrib["id"]: element for element in root.iter() if "id" in element.attrib}
    counts: dict[ElementTree.Element, int] = {}
    open_now: set[ElementTree.Element] = set()

    def count(element: ElementTree.Element) -> int:
        if element in open_now:
            raise SilhouetteError("unsupported", f"{where}: a <use> refers to itself; delete it")
        if element not in counts:
            open_now.add(element)
            total = 1 + sum(count(child) for child in element)
            if _tag(element) == "use":
                targets = [element.attrib[key].strip()[1:] for key in _HREFS if key in element.attrib]
                total += sum(count(named[target]) for target in targets if target in named)
            open_now.discard(element)
            counts[element] = total
        return counts[element]

    try:
        total = count(root)
    except RecursionError as error:
        raise SilhouetteError("unsupported", f"{where}: elements are nested too deeply; flatten the file") from error
    if total > _MAX_DRAWN:
        raise SilhouetteError("too-large", f"{where}: {total} elements are more than {_MAX_DRAWN}; simplify the file")


def _refuse_clipping(root: ElementTree.Element, where: Path) -> None:
    """Clip paths and masks are not applied; a clip path that is one rectangle (the page, as exported) may stay."""
    named = {element.attrib["id"]: element for element in root.iter() if "id" in element.attrib}
    for element in root.iter():
        style = element.attrib.get("style", "")
        for kind in ("clip-path", "mask"):
            given = element.attrib.get(kind) or (re.findall(rf"(?:^|;)\s*{kind}\s*:([^;]*)", style) or [""])[-1]
            target = re.search(r"url\(\s*['\"]?#([^)'\"]+)", given)
            if target is None:
                continue
            content = named.get(target[1].strip())
            page = kind == "clip-path" and content is not None and [_tag(child) for child in content] == ["rect"]
            if not page:
                raise SilhouetteError(
                    "unsupported", f"{where}: <{_tag(element)}> has a {kind}; apply it to the path, or export as PNG"
                )


def _hide(root: ElementTree.Element) -> None:
    for parent in list(root.iter()):
        if _tag(parent) == "defs":
            continue
        for place, child in enumerate(list(parent)):
            if _tag(child) in _NOT_DRAWN:
                wrapper = ElementTree.Element(f"{{{NAMESPACE}}}defs")
                wrapper.append(child)
                parent[place] = wrapper


def _tag(element: ElementTree.Element) -> str:
    return str(element.tag).rpartition("}")[2]

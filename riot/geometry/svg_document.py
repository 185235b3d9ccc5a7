"""SVG file → XML tree that is safe and simple to draw: no declarations, no other files, no hidden content drawn.

Scripts, text, embedded pictures and animation are removed before anything interprets the tree.
"""

from __future__ import annotations

import os
import re
from pathlib import Path
from xml.etree import ElementTree
from xml.parsers import expat

from riot.errors import SilhouetteError
from riot.geometry.limits import SVG_BYTES, TooManyBytes, read_bytes
from riot.geometry.machine_errors import is_of_machine

NAMESPACE = "http://www.w3.org/2000/svg"

_MAX_DRAWN = 100_000
"""Greatest number of elements and points after all ``<use>`` references are followed. Ours: it bounds the time."""

_MAX_STYLE = 10_000
"""Greatest length of all style sheets together, characters. Ours: the parser's time grows with the square."""

_MAX_ATTRIBUTE = 2_000
"""Greatest length of an attribute that is no path, characters. Ours, for the same reason."""

_MAX_ATTRIBUTES = 2_000_000
"""Greatest length of all such attributes together, characters. Ours."""

_MAX_DIGITS = 64
"""Greatest number of digits in a row. Ours: several times as many as a coordinate can have."""

_HREFS = ("href", "{http://www.w3.org/1999/xlink}href")
_GEOMETRY = ("d", "points")
_FOREIGN = (
    *("script", "text", "image", "foreignObject", "metadata", "title", "desc", "font", "filter"),
    *("animate", "animateTransform", "animateMotion", "animateColor", "set", "audio", "video", "iframe"),
)
_NOT_DRAWN = ("symbol", "mask", "marker", "clipPath", "pattern", "filter", "linearGradient", "radialGradient")
_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_OTHER_FILE = re.compile(r"@import|url\(\s*['\"]?\s*(?!['\"]?\s*#)", re.IGNORECASE)


def load(path: str | os.PathLike[str]) -> ElementTree.Element:
    """Parse an SVG file; what is only drawn by reference (symbols, masks …) is moved into ``<defs>``.

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
        data = read_bytes(where, SVG_BYTES)
    except TooManyBytes as error:
        raise SilhouetteError("too-large", f"{where}: {error}; simplify the file") from error
    except (OSError, ValueError) as error:  # ValueError: a path with a null character
        if is_of_machine(error):
            raise
        reason = getattr(error, "strerror", error)
        raise SilhouetteError("unreadable", f"{where}: cannot be read ({reason}); check the path") from error
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
    if _tag(root) != "svg":
        raise SilhouetteError(
            "unreadable", f"{where}: the XML is no SVG (its root is <{_tag(root)}>); export the drawing as SVG or PNG"
        )
    _refuse_references(root, where)
    _remove_foreign(root)
    _refuse_long_text(root, where)
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


def _remove_foreign(root: ElementTree.Element) -> None:
    """Take out what is no geometry, what editors keep under names of their own, and what is no number in ``points``.

    For a broken list of points svgelements would try every way to pair its digits.
    """
    for parent in list(root.iter()):
        for child in [child for child in parent if _tag(child) in _FOREIGN or _space(child.tag) not in ("", NAMESPACE)]:
            parent.remove(child)
        for name in [name for name in parent.attrib if _space(name) and name not in _HREFS]:
            del parent.attrib[name]
        if "points" in parent.attrib:
            parent.attrib["points"] = " ".join(_NUMBER.findall(parent.attrib["points"]))


def _refuse_long_text(root: ElementTree.Element, where: Path) -> None:
    style = total = 0
    for element in root.iter():
        style += len("".join(element.itertext())) if _tag(element) == "style" else 0
        for key, value in element.attrib.items():
            if key in _GEOMETRY:
                long = re.search(f"[0-9]{{{_MAX_DIGITS + 1}}}", value) is not None
                limit = f"a number of more than {_MAX_DIGITS} digits"
            else:
                total += len(value)
                long = len(value) > _MAX_ATTRIBUTE
                limit = f"more than {_MAX_ATTRIBUTE} characters"
            if long:
                raise SilhouetteError(
                    "too-large", f"{where}: {key} of <{_tag(element)}> has {limit}; save as plain SVG, or simplify"
                )
    if style > _MAX_STYLE or total > _MAX_ATTRIBUTES:
        what, most = ("style sheets have", _MAX_STYLE) if style > _MAX_STYLE else ("attributes have", _MAX_ATTRIBUTES)
        raise SilhouetteError(
            "too-large", f"{where}: {what} more than {most} characters in all; save as plain SVG, or simplify"
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
            total = 1 + _pairs(element) + sum(count(child) for child in element)
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
        raise SilhouetteError(
            "too-large", f"{where}: {total} elements and points are more than {_MAX_DRAWN}; simplify the drawing"
        )


def _pairs(element: ElementTree.Element) -> int:
    """How many points an element's geometry has, about: half its numbers."""
    return sum(len(_NUMBER.findall(element.attrib.get(key, ""))) for key in _GEOMETRY) // 2


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
        for index, child in enumerate(list(parent)):
            if _tag(child) in _NOT_DRAWN:
                wrapper = ElementTree.Element(f"{{{NAMESPACE}}}defs")
                wrapper.append(child)
                parent[index] = wrapper


def _space(name: str) -> str:
    return name.rpartition("}")[0].removeprefix("{")


def _tag(element: ElementTree.Element) -> str:
    return str(element.tag).rpartition("}")[2]

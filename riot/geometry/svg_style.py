"""What a drawing's CSS asks for that resvg does not do, or does in another way than browsers (ours).

The lists come from drawing each feature with both (tests/unit/test_svg_style.py has one of every kind).
"""

from __future__ import annotations

import re
from xml.etree import ElementTree

from PIL import ImageColor

_COMMENT = re.compile(r"/\*.*?\*/|<!--|-->", re.DOTALL)
_NOT_IN_FORCE = r"print|speech|\(\s*prefers-color-scheme\s*:\s*dark\s*\)|\(\s*prefers-reduced-motion\s*:\s*reduce\s*\)"
_IGNORED_RULES = re.compile(
    r"@charset[^;{]*;|@font-face\s*\{[^{}]*\}"
    r"|@(?:-webkit-|-moz-)?keyframes[^{}]*\{(?:[^{}]*\{[^{}]*\})*[^{}]*\}"
    rf"|@media\s+(?:only\s+)?(?:{_NOT_IN_FORCE})\s*\{{(?:[^{{}}]*\{{[^{{}}]*\}})*[^{{}}]*\}}",
    re.IGNORECASE,
)
"""Rules that change no still picture on a light screen. Keyframes count only by the property that names them."""

_RULE = re.compile(r"([^{}]*)\{([^{}]*)\}")
_AT_RULE = re.compile(r"@[\w-]+(?:\s*[^{;]{0,40})?")
_SELECTOR = re.compile(
    r"~(?!=)"  # a later sibling; ~= is a word of an attribute
    r"|(?<!:):(?!:|first-child\b|(?:hover|active|focus|visited|target|focus-within|focus-visible)\b)[\w-]+"
    r"|[\^$*|]=|\|"
    r"|['\"\w]\s+[iIsS]\s*\]"
    r"|\\|&"
)
"""Parts of selectors that resvg does not understand; those it may drop, since nothing is hovered, are left out."""

_FUNCTION = re.compile(r"([\w-]+)\(")
_PAINT_FUNCTIONS = frozenset({"url", "rgb", "rgba", "hsl", "hsla"})
_FILTER_FUNCTIONS = frozenset({"blur", "drop-shadow", "brightness", "contrast", "grayscale", "hue-rotate", "invert",
                               "opacity", "saturate", "sepia"})  # fmt: skip
_COLOURS = frozenset({"fill", "stroke", "color", "stop-color", "flood-color", "lighting-color"})
_COLOUR_WORDS = frozenset({*ImageColor.colormap, "none", "transparent", "currentColor", "inherit"})
_HEX = re.compile(r"#(?:[0-9a-fA-F]{3,4}|[0-9a-fA-F]{6}|[0-9a-fA-F]{8})")
_CALL = re.compile(r"[\w-]+\([^()]*\)")
_LATER_COLOUR = re.compile(
    r"(?:rgb|hsl)a?\((?:[^(),]{1,40}[ /][^(),]{1,40}|(?:[^(),]{1,40},){3}[^(),]{1,40}%[^(),]{0,9}"
    r"|[^(),]{1,40}(?:deg|rad|turn)[^()]{1,80})\)"
)
"""Colours without commas, with an opacity in percent, or with a unit of angle."""
_KEYS = frozenset({"display", "visibility", "fill-rule", "clip-rule"})
"""Properties whose values are words."""
_KEYWORDS = re.compile(r"^(?:initial|unset|revert|revert-layer|context-fill|context-stroke)$")
_UNITS = re.compile(r"[\d.](?:rem|vw|vh|vmin|vmax|ch|q|lh|cap|ic)\b", re.IGNORECASE)

_PROPERTIES = frozenset(
    [
        "all",
        "animation",
        "animation-name",
        "backdrop-filter",
        "clip",
        "contain",
        "content-visibility",
        "cx",
        "cy",
        "d",
        "height",
        "inset",
        "mask-border",
        "mask-clip",
        "mask-composite",
        "mask-image",
        "mask-mode",
        "mask-origin",
        "mask-position",
        "mask-repeat",
        "mask-size",
        "offset-path",
        "perspective",
        "r",
        "rotate",
        "rx",
        "ry",
        "scale",
        "transform",
        "transform-box",
        "translate",
        "width",
        "x",
        "y",
        "zoom",
    ]
)
"""CSS properties that change what a browser draws, and not what resvg does."""

_PREFIXED = _PROPERTIES | {"mask", "clip-path", "filter"}
"""Those that browsers know with ``-webkit-`` before them."""

_ATTRIBUTES = frozenset({"transform-box", "mask-image", "mask-border", "offset-path"})
"""Those of them that are attributes, too."""

_VALUES = frozenset({("vector-effect", "non-scaling-stroke")})
_NOT_STYLE = frozenset({"d", "points", "transform", "gradientTransform", "patternTransform", "id", "class", "style",
                        "values", "viewBox", "href", "{http://www.w3.org/1999/xlink}href"})  # fmt: skip


def unsupported_sheet(element: ElementTree.Element) -> str | None:
    """Name the first thing in a ``<style>`` element that is not drawn as in a browser; None if all is.

    >>> unsupported_sheet(ElementTree.fromstring("<style>rect:nth-child(2) {fill: none}</style>"))
    'the selector "rect:nth-child(2)"'
    """
    kind = element.get("type", "").strip().lower()
    if kind not in ("", "text/css"):
        return None  # for neither
    if element.get("media", "all").strip().lower() not in ("", "all", "screen"):
        return f'a style sheet for media="{element.get("media")}"'
    sheet = _IGNORED_RULES.sub(" ", _COMMENT.sub(" ", _one_line(element.text or "")))
    at_rule = _AT_RULE.search(sheet)
    if at_rule is not None:
        return f"the rule {_short(at_rule[0])}"
    for selector, body in _RULE.findall(sheet):
        if _SELECTOR.search(selector):
            return f'the selector "{_short(selector)}"'
        lacking = _unsupported(body, in_sheet=True)
        if lacking is not None:
            return lacking
    rest = _RULE.sub("", sheet).strip()
    return f'the nested or broken rule "{_short(rest)}"' if "{" in rest or "}" in rest else None


def unsupported_attributes(element: ElementTree.Element, is_root: bool) -> str | None:
    """Name the first thing in an element's attributes that is not drawn as in a browser; None if all is.

    >>> unsupported_attributes(ElementTree.fromstring('<g style="transform: rotate(5deg)"/>'), False)
    'the CSS property transform'
    """
    for name, value in element.attrib.items():
        if is_root and name == "transform":
            return "a transform of the whole page"
        if name == "style":
            lacking = _unsupported(
                _COMMENT.sub(" ", _one_line(value)), frozenset({"width", "height"}) if is_root else frozenset()
            )
        elif name in _ATTRIBUTES:
            lacking = f"the attribute {name}"
        elif name in _NOT_STYLE or name.startswith(("data-", "aria-", "on")):
            lacking = None
        else:
            lacking = _unsupported_value(name, value)
        if lacking is not None:
            return lacking
    return None


def _unsupported(declarations: str, allowed: frozenset[str] = frozenset(), in_sheet: bool = False) -> str | None:
    for declaration in declarations.split(";"):
        name, colon, value = declaration.partition(":")
        name = name.strip()
        if not colon and name and in_sheet:  # a browser drops it alone, resvg the rule
            return f'the broken declaration "{_short(name)}"'
        if name.startswith("-webkit-") and name.removeprefix("-webkit-") in _PREFIXED:
            return f"the CSS property {name}"
        if not colon or (name.startswith("-") and not name.startswith("--")):
            continue
        if (name in _PROPERTIES and name not in allowed) or name.startswith("--"):
            return f"the CSS property {name}"
        if name != name.lower():
            return f"the CSS property {_short(name)}, not in lower case"
        lacking = _unsupported_value(name, value.replace("!important", ""))
        if lacking is not None:
            return lacking
    return None


def _unsupported_value(name: str, value: str) -> str | None:
    value = _one_line(value)
    if name.startswith(("font", "text", "line-", "letter-")):
        return None  # there is no text
    known = _PAINT_FUNCTIONS | (_FILTER_FUNCTIONS if name == "filter" else frozenset())
    if (
        _KEYWORDS.match(value)
        or (name, value) in _VALUES
        or _UNITS.search(value)
        or any(function not in known for function in _FUNCTION.findall(value))
        or _LATER_COLOUR.search(value)
        or (name in _KEYS and value != value.lower())
        or (name in _COLOURS and not _is_colour(value))
    ):
        return f"{name}: {_short(value)}"
    return None


def _is_colour(value: str) -> bool:
    words = _CALL.sub(" ", value.removesuffix("!important")).split()
    return all(word in _COLOUR_WORDS or _HEX.fullmatch(word) for word in words)


def _short(text: str) -> str:
    return _one_line(text)[:60]


def _one_line(text: str) -> str:
    return " ".join(text.split())

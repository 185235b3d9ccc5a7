"""The style sheets of SVG: for a whole file, and for a page that shows many pictures in the reader's colours. Ours."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from riot.draw.palette import PENS, PIECES, Pen, colour

FONT = "ui-sans-serif, system-ui, 'Segoe UI', 'Helvetica Neue', Arial, sans-serif"


def page_style() -> str:
    """Rules for all fragments of a page: colours are variables ``--r-…``, widths are pixels whatever the scale."""
    # One rule a pen, without ancestors: selectors do not see beyond the shadow tree in which <use> shows a piece.
    rules = (_rule(name, pen, 1.0, lambda token: f"var(--r-{token})") for name, pen in PENS.items())
    return "".join(rule.replace("}", ";vector-effect:non-scaling-stroke}") for rule in rules)


def page_colours(scheme: Mapping[str, str]) -> str:
    """The values of the variables that `page_style` uses.

    >>> page_colours({"paper": "#ffffff"})[:18]
    '--r-paper:#ffffff;'
    """
    tokens = dict(scheme) | {f"piece{k}": value for k, value in enumerate(PIECES)}
    return "".join(f"--r-{token}:{value};" for token, value in tokens.items())


def file_style(pen: float, scheme: Mapping[str, str]) -> str:
    """Rules of a whole file: colours of a scheme, widths in SVG units, of which a pen has ``pen``.

    >>> from riot.draw.palette import LIGHT
    >>> file_style(2.0, LIGHT)[:16]
    'text{font-family'
    """
    rules = [f"text{{font-family:{FONT}}}", "image{image-rendering:smooth}"]
    rules += [_rule(name, value, pen, lambda token: colour(token, scheme)) for name, value in PENS.items()]
    return "".join(rules)


def _rule(name: str, pen: Pen, unit: float, paint: Callable[[str], str]) -> str:
    """The rule of one pen, whose width is counted in ``unit``."""
    declarations = [f"fill:{paint(pen.fill) if pen.fill else 'none'}"]
    if pen.stroke:
        declarations += [f"stroke:{paint(pen.stroke)}", f"stroke-width:{number(pen.width * unit)}"]
        declarations += ["stroke-linejoin:round", "stroke-linecap:round"]
    if pen.dash:
        declarations.append(f"stroke-dasharray:{' '.join(number(step * unit) for step in pen.dash)}")
    if pen.opacity < 1.0:
        declarations.append(f"opacity:{number(pen.opacity)}")
    return f".r-{name}{{{';'.join(declarations)}}}"


def number(value: float) -> str:
    """A number with as many digits as a picture shows.

    >>> number(2.0 / 3.0)
    '0.6667'
    """
    return f"{value:.4g}"

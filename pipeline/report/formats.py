"""How numbers look on the pages: filters of the templates. A value that is None or not finite is a dash. Ours."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from pipeline.tables.messages import several
from riot.errors import needs_extra

with needs_extra("mine"):
    from markupsafe import Markup

MISSING = "–"
"""Stands for a number that is not known."""

THIN = "\N{NARROW NO-BREAK SPACE}"


def number(value: float | None, digits: int = 3) -> str:
    """A score or length with a fixed number of decimals.

    >>> number(0.12345), number(None)
    ('0.123', '–')
    """
    return f"{value:.{digits}f}" if value is not None and math.isfinite(value) else MISSING


def degrees(value: float | None) -> str:
    """An angle, given in radians.

    >>> degrees(math.pi)
    '180.0°'
    """
    return f"{math.degrees(value):.1f}°" if value is not None and math.isfinite(value) else MISSING


def percent(value: float | None) -> str:
    """A share, given as a part of 1.

    >>> percent(0.0123), percent(math.nan)
    ('1.2\u202f%', '–')
    """
    return f"{100.0 * value:.1f}{THIN}%" if value is not None and math.isfinite(value) else MISSING


def residual(value: float | None) -> str:
    """A residual by its order of magnitude, which is what matters.

    >>> residual(7e-16)
    Markup('7·10<sup>−16</sup>')
    """
    if value is None or not math.isfinite(value):
        return MISSING
    if value == 0:
        return "0"
    digit, _, exponent = f"{value:.0e}".partition("e")
    return Markup(f"{digit}·10<sup>{int(exponent)}</sup>".replace("-", "−"))


def count(value: float | None) -> str:
    """A whole number with thin spaces between thousands.

    >>> count(1234).split()
    ['1', '234']
    """
    return f"{round(value):,}".replace(",", THIN) if value is not None and math.isfinite(value) else MISSING


def seconds(value: float | None) -> str:
    """A time: tenths below a minute, minutes and seconds below an hour, hours and minutes above.

    >>> seconds(83.0).split()
    ['1', 'min', '23', 's']
    """
    if value is None or not math.isfinite(value):
        return MISSING
    if value < 60:
        return f"{value:.1f}{THIN}s" if value >= 0.05 else f"0{THIN}s"
    whole = round(value)
    if whole < 3600:
        return f"{whole // 60}{THIN}min {whole % 60:02d}{THIN}s"
    return f"{whole // 3600}{THIN}h {whole % 3600 // 60:02d}{THIN}min"


FILTERS: Mapping[str, Callable[..., str]] = {
    "number": number,
    "degrees": degrees,
    "percent": percent,
    "residual": residual,
    "count": count,
    "seconds": seconds,
    "several": several,
}
"""By the name that templates use."""

"""Small pieces of HTML, and how numbers look in it. All text is escaped here or by its caller, never trusted."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

from riot.draw.svg import escape

NOTHING = "–"
"""Stands for a number that is not there."""

SHOWN_PAIRS = 20
"""Rows of pairs in sight; the others can be unfolded."""

ICON = (
    "data:image/svg+xml,%3Csvg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 16 16'%3E"
    "%3Cpath d='M1 15L8 1v14z' fill='%234683c5'/%3E%3Cpath d='M15 15L8 1v14z' fill='%23e9c266'/%3E%3C/svg%3E"
)


def number(value: float | None, digits: int = 3) -> str:
    """A score or length with a fixed number of decimals."""
    if value is None or not math.isfinite(value):
        return NOTHING
    return f"{value:.{digits}f}"


def degrees(value: float | None) -> str:
    """An angle given in radians."""
    return NOTHING if value is None or not math.isfinite(value) else f"{math.degrees(value):.1f}°"


def small(value: float | None) -> str:
    """A residual: its order of magnitude is what matters."""
    if value is None or not math.isfinite(value):
        return NOTHING
    if value == 0:
        return "0"
    digit, _, exponent = f"{value:.0e}".partition("e")
    return f"{digit}·10<sup>{int(exponent)}</sup>".replace("-", "−")


def count(value: float | None) -> str:
    """A whole number with thin spaces between thousands."""
    if value is None or not math.isfinite(value):
        return NOTHING
    return f"{round(value):,}".replace(",", "\N{NARROW NO-BREAK SPACE}")


def seconds(value: float | None) -> str:
    """A time: tenths below a minute, minutes and seconds below an hour, hours and minutes above."""
    if value is None or not math.isfinite(value):
        return NOTHING
    if value < 60:
        return f"{value:.1f}\N{NARROW NO-BREAK SPACE}s" if value >= 0.05 else "0\N{NARROW NO-BREAK SPACE}s"
    whole = round(value)
    if whole < 3600:
        return f"{whole // 60}\N{NARROW NO-BREAK SPACE}min {whole % 60:02d}\N{NARROW NO-BREAK SPACE}s"
    return f"{whole // 3600}\N{NARROW NO-BREAK SPACE}h {whole % 3600 // 60:02d}\N{NARROW NO-BREAK SPACE}min"


def table(head: Sequence[str], rows: Iterable[Sequence[str]], numeric: Sequence[bool], caption: str) -> str:
    """A table of heads and cells that already are HTML; numeric columns are flush right. It scrolls if too wide."""
    kinds = [' class="n"' if flush else "" for flush in numeric]
    top = "".join(f'<th scope="col"{kind}>{name}</th>' for name, kind in zip(head, kinds, strict=True))
    body = "".join(
        "<tr>" + "".join(f"<td{kind}>{cell}</td>" for cell, kind in zip(row, kinds, strict=True)) + "</tr>\n"
        for row in rows
    )
    return (
        f'<div class="scroll" tabindex="0" role="region" aria-label="{escape(caption)}"><table>'
        f'<caption class="unseen">{escape(caption)}</caption>'
        f"<thead><tr>{top}</tr></thead>\n<tbody>{body}</tbody></table></div>"
    )


def facts(pairs: Iterable[tuple[str, str]]) -> str:
    """A list of named values; both already are HTML."""
    cells = "".join(f"<div><dt>{name}</dt><dd>{value}</dd></div>" for name, value in pairs)
    return f'<dl class="facts">{cells}</dl>'


def section(anchor: str, title: str, body: str, note: str = "") -> str:
    """A section of the page; ``title`` and ``note`` are text, ``body`` is HTML."""
    under = f'<p class="note">{escape(note)}</p>' if note else ""
    return f'<section id="{anchor}"><h2>{escape(title)}</h2>{under}{body}</section>\n'


def linked(links: Mapping[int, str], rank: int, content: str) -> str:
    """HTML as a link to the transform of a rank, if there is one."""
    return f'<a href="{escape(links[rank])}">{content}</a>' if rank in links else content


def document(title: str, head: str, body: str) -> str:
    """A whole page: ``title`` is text, ``head`` what else belongs there, both it and ``body`` HTML."""
    return (
        "<!DOCTYPE html>\n"
        '<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<title>{escape(title)}</title><link rel="icon" href="{ICON}">\n'
        f"{head}</head>\n<body>\n{body}</body></html>\n"
    )


def hidden_definitions(pieces: Iterable[str]) -> str:
    """Definitions of pieces that pictures of the page show, each once; they are not seen themselves."""
    found = "".join(dict.fromkeys(pieces))
    return f'<svg width="0" height="0" style="position:absolute" aria-hidden="true">{found}</svg>\n'

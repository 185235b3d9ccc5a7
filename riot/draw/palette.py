"""The colours and pens of every picture; the one home of both. Ours."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

PIECES = ("#4683c5", "#e9c266", "#a94755", "#63beaf", "#dc7a44", "#544380", "#e6c4e7", "#3d6a3f")
"""Colours of the pieces in chain order.

Neighbours differ in lightness as well as in hue, so that they stay apart in grey print and for colour-blind eyes
(a test holds the latter under a simulation of red and green blindness).
"""

LIGHT: Mapping[str, str] = MappingProxyType(
    {
        "paper": "#ffffff",
        "ink": "#23262b",
        "muted": "#6b7078",
        "shade": "#dcdad4",
        "seam": "#ffffff",
        "casing": "#ffffff",
    }
)
"""Named colours on a light page."""

DARK: Mapping[str, str] = MappingProxyType(
    {
        "paper": "#1d2025",
        "ink": "#eceae5",
        "muted": "#9aa0aa",
        "shade": "#4a4e56",
        "seam": "#1d2025",
        "casing": "#eceae5",
    }
)
"""The same names on a dark page; the pieces keep their colours."""


@dataclass(frozen=True)
class Pen:
    """How a mark looks: names of colours (``None`` = nothing is painted), widths in pens (about one pixel)."""

    fill: str | None = None
    stroke: str | None = None
    width: float = 1.0
    opacity: float = 1.0
    dash: tuple[float, ...] = ()


PENS: Mapping[str, Pen] = MappingProxyType(
    {
        "silhouette": Pen(fill="shade"),
        "outline": Pen(stroke="ink", width=1.5),
        "casing": Pen(stroke="casing", width=5.0),
        "seam": Pen(stroke="seam", width=1.1, opacity=0.8, dash=(3.0, 2.5)),
        "hinge": Pen(fill="ink", stroke="paper", width=1.0),
        "open": Pen(fill="paper", stroke="ink", width=1.2),
        "cut": Pen(stroke="ink", width=0.7, opacity=0.8),
        "rule": Pen(stroke="shade", width=1.0),
        "caption": Pen(fill="ink"),
        "note": Pen(fill="muted"),
    }
    | {f"piece{k}": Pen(fill=f"piece{k}", stroke="paper", width=0.8) for k in range(len(PIECES))}
    | {f"edge{k}": Pen(stroke=f"piece{k}", width=3.0) for k in range(len(PIECES))}
)
"""Every pen by name; a mark names its pen, a writer looks it up."""


LASER_COLOURS: Mapping[str, str] = MappingProxyType({"engrave": "#000000", "score": "#0000ff", "cut": "#ff0000"})
"""By layer of a laser, in the order of work: LightBurn's layers 00, 01 and 02."""

PAPER_PENS: Mapping[str, Pen] = MappingProxyType(
    {
        "laser-engrave": Pen(fill=LASER_COLOURS["engrave"]),
        "laser-score": Pen(stroke=LASER_COLOURS["score"], width=0.7),
        "laser-cut": Pen(stroke=LASER_COLOURS["cut"], width=0.7),
    }
)
"""Pens of printed pages alone, which no style sheet needs."""


def hue(piece: int, count: int) -> int:
    """Index into `PIECES` for one piece of ``count``; the last never looks like the first, its neighbour.

    >>> [hue(piece, 9) for piece in range(9)]
    [0, 1, 2, 3, 4, 5, 6, 7, 4]
    """
    k = piece % len(PIECES)
    return len(PIECES) // 2 if piece > 0 and piece == count - 1 and k == 0 else k


def colour(name: str, scheme: Mapping[str, str]) -> str:
    """The ``#rrggbb`` of a named colour; one that is given so stays.

    >>> colour("paper", LIGHT), colour("piece0", LIGHT)
    ('#ffffff', '#4683c5')
    """
    if name.startswith("#"):
        return name
    return PIECES[int(name[5:])] if name.startswith("piece") else scheme[name]

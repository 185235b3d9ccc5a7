"""One state of a piece of work: what was given, what was chosen, and the transform that follows."""

from __future__ import annotations

from typing import Literal

from msgspec import Struct

from studio.messages import Side

Points = tuple[float, ...]
"""Flat list of coordinates."""


class Pin(Struct, frozen=True):
    """A pin of an outline: points kept, or a line drawn; in the frame of the input before it is bent."""

    kind: Literal["keep", "draw"]
    points: Points


class StiffRegion(Struct, frozen=True):
    """A polygon within which strain costs ``factor`` times as much; in the frame of the input."""

    polygon: Points
    factor: float


class State(Struct, frozen=True):
    """What a person has done so far.

    Parameters
    ----------
    step : str
        What was done last, as undo calls it.
    p, q : str, optional
        Digests of the inputs.
    number_p, number_q : int, optional
        Their numbers in the collection, if they are of it.
    pieces : two int, optional
        Least and greatest number of pieces.
    weight : float, optional
        Of bending against cutting; None: no bend.
    root : str, optional
        Digest of the transform before anything was bent or pinned: the trunks.
    base : str, optional
        Digest of the same after the bend, without pins.
    shown : str, optional
        Digest of what is shown: base with the pins.
    pins_p, pins_q, stiff_p, stiff_q
        Pins and stiff regions of both inputs.
    """

    step: str = "start"
    p: str | None = None
    q: str | None = None
    number_p: int | None = None
    number_q: int | None = None
    pieces: tuple[int, int] | None = None
    weight: float | None = 1.0
    root: str | None = None
    base: str | None = None
    shown: str | None = None
    pins_p: tuple[Pin, ...] = ()
    pins_q: tuple[Pin, ...] = ()
    stiff_p: tuple[StiffRegion, ...] = ()
    stiff_q: tuple[StiffRegion, ...] = ()

    def pins(self, side: Side) -> tuple[Pin, ...]:
        """The pins of one side."""
        return self.pins_p if side == "p" else self.pins_q

    def stiff(self, side: Side) -> tuple[StiffRegion, ...]:
        """The stiff regions of one side."""
        return self.stiff_p if side == "p" else self.stiff_q

"""What browsers send: requests and edits, each checked when it is read; coordinates are flat lists [x0, y0, x1, y1, …].

Coordinates are in the frames of the shapes as they are shown, y upwards; ``seq`` is the sender's growing counter.
"""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from msgspec import DecodeError, Meta, Struct, json

from riot.errors import RiotError
from riot.types import FloatArray

Side = Literal["p", "q"]
Flat = Annotated[tuple[float, ...], Meta(min_length=2, max_length=4000)]
Point = Annotated[tuple[float, ...], Meta(min_length=2, max_length=2)]
Line = Annotated[tuple[float, ...], Meta(min_length=4, max_length=4000)]
Number = Annotated[int, Meta(ge=0)]
Name = Annotated[str, Meta(min_length=1, max_length=80)]


class RequestError(RiotError, ValueError):
    """A message of a browser that is not understood."""


class _Edit(Struct, frozen=True, forbid_unknown_fields=True, tag_field="kind", tag=str.lower):
    """What changes the transform."""


class Draw(_Edit, frozen=True):
    """Replace the stretch of an outline between the ends of a line by the line."""

    side: Side
    line: Line


class Pull(_Edit, frozen=True):
    """Pull a boundary point; the outline within ``reach`` of it, along the boundary, follows."""

    side: Side
    at: Point
    to: Point
    reach: Annotated[float, Meta(gt=0, le=2)] = 0.15


class Keep(_Edit, frozen=True):
    """Keep a boundary point, or the stretch through several."""

    side: Side
    points: Flat


class Unpin(_Edit, frozen=True):
    """Take a pin away."""

    side: Side
    index: Number


class Stiff(_Edit, frozen=True):
    """Paint stiffness along a stroke; a factor below 1 makes softer."""

    side: Side
    stroke: Flat
    radius: Annotated[float, Meta(gt=0, le=1)] = 0.1
    factor: Annotated[float, Meta(ge=0.001, le=1000)] = 20.0


class Erase(_Edit, frozen=True):
    """Erase painted stiffness along a stroke."""

    side: Side
    stroke: Flat
    radius: Annotated[float, Meta(gt=0, le=1)] = 0.1


class Unstiff(_Edit, frozen=True):
    """Take a stiff region away."""

    side: Side
    index: Number


class Corner(_Edit, frozen=True):
    """Move a trunk corner along the outline."""

    side: Side
    corner: Number
    to: Point


class Weight(_Edit, frozen=True):
    """Set the weight between bending and cutting; None: shapes are not bent."""

    weight: Annotated[float, Meta(ge=0.01, le=1000)] | None


class Choose(_Edit, frozen=True):
    """Take another transform of the same shapes."""

    transform: Name


class Pieces(_Edit, frozen=True):
    """Say how many pieces there may be; None: any number."""

    least: Annotated[int, Meta(ge=3, le=32)] | None
    most: Annotated[int, Meta(ge=3, le=32)] | None


class Swap(_Edit, frozen=True):
    """Let the two shapes change places."""


Edit = Draw | Pull | Keep | Unpin | Stiff | Erase | Unstiff | Corner | Weight | Choose | Pieces | Swap


class _Request(Struct, frozen=True, forbid_unknown_fields=True, tag_field="type", tag=lambda name: name.lower()):
    """What a browser asks for."""

    seq: Number


class EditRequest(_Request, frozen=True, tag="edit"):
    """Show what an edit would do (move), or do it (release)."""

    phase: Literal["move", "release"]
    edit: Edit


class Undo(_Request, frozen=True):
    """Go back a step."""


class Redo(_Request, frozen=True):
    """Go forward a step again."""


class Snapshot(_Request, frozen=True):
    """Keep the state under a name."""

    name: Name


class Restore(_Request, frozen=True):
    """Go to the state of a snapshot, as a new step."""

    name: Name


class Forget(_Request, frozen=True):
    """Delete a snapshot."""

    name: Name


class Alternatives(_Request, frozen=True):
    """Stream other transforms of the two shapes."""


class Partners(_Request, frozen=True):
    """Find the best partners in the collection, of a shape of it or of an input."""

    shape: Number | None = None
    side: Side | None = None


class Make(_Request, frozen=True):
    """Build the puzzle; settings are those of `riot.parameters.FabricationParameters`."""

    settings: dict[Name, float | bool | str] = {}
    fix: bool = False


class Stop(_Request, frozen=True):
    """End what runs in the background."""


Request = (
    EditRequest | Undo | Redo | Snapshot | Restore | Forget | Alternatives | Partners | Make | Stop
)  # fmt: skip

MAX_BYTES = 1_000_000
"""A message with more bytes is refused."""

_DECODER: json.Decoder[Request] = json.Decoder(Request)


def read_request(text: str | bytes) -> Request:
    """Read a message; raises `RequestError` that says what is wrong.

    >>> read_request('{"type":"undo","seq":3}').seq
    3
    >>> read_request('{"type":"undo"}')
    Traceback (most recent call last):
    studio.messages.RequestError: not understood: Object missing required field `seq`
    """
    try:
        return _DECODER.decode(text)
    except (DecodeError, RecursionError) as error:
        raise RequestError(f"not understood: {error}") from None


def points_of(flat: tuple[float, ...]) -> FloatArray:
    """(k, 2) points of a flat list; raises `RequestError` if one is no number or lacks its second coordinate.

    >>> points_of((0.0, 1.0, 2.0, 3.0)).tolist()
    [[0.0, 1.0], [2.0, 3.0]]
    """
    points = np.array(flat, dtype=np.float64)
    if len(points) % 2 or not np.isfinite(points).all() or np.abs(points).max(initial=0.0) > 100.0:
        raise RequestError("not understood: coordinates come in pairs, and lie near the shape")
    return points.reshape(-1, 2)


def flat_of(points: FloatArray, digits: int = 5) -> list[float]:
    """A flat list of (k, 2) points, rounded.

    >>> flat_of(np.array([[0.123456, 1.0]]))
    [0.12346, 1.0]
    """
    flat: list[float] = np.round(points, digits).ravel().tolist()
    return flat

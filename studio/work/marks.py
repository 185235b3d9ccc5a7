"""Where pins and stiff regions lie on what is shown."""

from __future__ import annotations

from typing import Any

from msgspec import json

from studio.messages import flat_of, points_of
from studio.scene import scene_of
from studio.session.state import State
from studio.work.material import Files, forth, transform


def marks(state: State, files: Files) -> tuple[bytes, bytes]:
    """Pins and stiff regions of a state, as JSON, in the frames of its base: bent, if that is."""
    base = None if state.base is None else transform(files, state.base)
    pins: dict[str, list[dict[str, Any]]] = {}
    stiff: dict[str, list[dict[str, Any]]] = {}
    for side in ("p", "q"):

        def placed(points: tuple[float, ...], side: Any = side) -> list[float]:
            there = points_of(points)
            return flat_of(there if base is None else forth(there, base, side))

        pins[side] = [{"kind": pin.kind, "points": placed(pin.points)} for pin in state.pins(side)]
        stiff[side] = [{"polygon": placed(one.polygon), "factor": one.factor} for one in state.stiff(side)]
    return json.encode(pins), json.encode(stiff)


def scene(files: Files, digest: str) -> bytes:
    """The scene of a transform, as JSON."""
    return json.encode(scene_of(transform(files, digest), digest))

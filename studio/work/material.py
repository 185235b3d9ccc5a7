"""Shapes and transforms by digest in a process that computes: read once, kept while they are used."""

from __future__ import annotations

import json
from collections import OrderedDict
from collections.abc import Callable, Hashable, Mapping
from typing import TypeVar, cast

from riot.construction.dissected_plan import DissectedPlan, dissect_plan
from riot.construction.pins import Pin as GeometryPin
from riot.construction.pins import Pins
from riot.construction.replan import plan_of
from riot.construction.stiff import StiffRegions
from riot.geometry.modes import Modes, modes
from riot.geometry.shape import Shape
from riot.parameters import BendParameters, ConstructParameters
from riot.transform import shape_document
from riot.transform.riot_file import from_json
from riot.transform.transform import Transform
from riot.types import FloatArray
from studio.messages import Side, points_of
from studio.session.state import Pin, State

Files = Mapping[str, bytes]
"""Documents of shapes and transforms by digest."""

Value = TypeVar("Value")

KEPT = 64
"""So many values are kept: a person goes back and forth between a few transforms."""

MADE = ConstructParameters(max_lost_contact=1.0)
"""A transform that is made lost no more contact than it may; made again it may seem to lose a little more."""

_kept: OrderedDict[Hashable, object] = OrderedDict()


def once(key: Hashable, make: Callable[[], Value]) -> Value:
    """The value of a key, made when it is asked for first, or after it was not used for long.

    >>> once("one", lambda: 1), once("one", lambda: 2)
    (1, 1)
    """
    if key not in _kept:
        _kept[key] = make()
        while len(_kept) > KEPT:
            _kept.popitem(last=False)
    _kept.move_to_end(key)
    return cast(Value, _kept[key])


def shape(files: Files, digest: str) -> Shape:
    """The shape with this digest."""
    return once(("shape", digest), lambda: shape_document.from_document(json.loads(files[digest])))


def transform(files: Files, digest: str) -> Transform:
    """The transform with this digest."""
    return once(("transform", digest), lambda: from_json(files[digest].decode("utf-8"), "the transform"))


def dissected(files: Files, digest: str) -> DissectedPlan:
    """The plan of a transform with both trunks dissected."""
    return once(("dissected", digest), lambda: dissect_plan(plan_of(transform(files, digest)), MADE))


def shape_modes(files: Files, state: State, side: Side) -> Modes:
    """The elastic modes of an input, stiff where it was painted so."""
    digest = state.p if side == "p" else state.q
    assert digest is not None
    regions = stiff_regions(state)
    chosen = BendParameters()
    return once(
        ("modes", digest, state.stiff(side)),
        lambda: modes(shape(files, digest), chosen.modes, chosen.straight, regions.p if side == "p" else regions.q),
    )


def stiff_regions(state: State) -> StiffRegions:
    """The stiff regions of a state, as geometry."""
    p, q = (tuple((points_of(region.polygon), region.factor) for region in state.stiff(side)) for side in ("p", "q"))
    return StiffRegions(p, q)


def pins_of(state: State, base: Transform) -> Pins:
    """The pins of a state on the shapes of a transform, bent if these are."""
    return Pins(side_pins(state.pins_p, base, "p"), side_pins(state.pins_q, base, "q"))


def side_pins(pins: tuple[Pin, ...], base: Transform, side: Side) -> tuple[GeometryPin, ...]:
    """Pins of one side on the shape of a transform."""
    return tuple(GeometryPin(forth(points_of(pin.points), base, side), pin.kind == "draw") for pin in pins)


def forth(points: FloatArray, base: Transform, side: Side) -> FloatArray:
    """Where points (k, 2) of an input lie on the shape of a transform."""
    bend = base.bend_p if side == "p" else base.bend_q
    return points if bend is None else bend.field.at(points)


def back(points: FloatArray, base: Transform, side: Side) -> FloatArray:
    """Where points (k, 2) of the shape of a transform come from on the input."""
    bend = base.bend_p if side == "p" else base.bend_q
    return points if bend is None else bend.field.back(points)

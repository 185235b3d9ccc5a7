"""Pictures of two pieces that are to be joined, one over the other, the pin above, as in a construction kit. Ours."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from riot.draw.solid import Body, View, prisms, render
from riot.fabricate.export.paper import Frame
from riot.fabricate.export.picture import EYE, METAL, dashes, middle_of_face, numbered, piece_body, tubes

if TYPE_CHECKING:
    from riot.fabricate.model import Design

LIFT, PIN_LIFT, SLEEVE_DROP = 1.4, 2.8, 1.8
"""In thicknesses: how far the upper piece and the pin stand over the lower piece, and a sleeve below it."""

JOINT_PIXEL_MM = 0.2
JOINT_NUMBER_MM = 9.0


def joint_view(design: Design, before: int, after: int) -> View:
    """Two neighbours in the chain, their hinge at the origin, and what joins them along its axis."""
    pieces, height = design.pieces, design.parameters.height
    frames = {before: Frame(0.0, -pieces[before].length, 0.0), after: Frame(0.0, 0.0, 0.0)}
    upper = after if pieces[after].start.role == "upper" else before
    lifts = {index: LIFT * height if index == upper else 0.0 for index in frames}
    bodies = [piece_body(design, index, frame, False, "p", None, lifts[index]) for index, frame in frames.items()]
    axis = np.zeros(2)
    if pieces[after].start.kind == "telescopic" and design.telescope is not None:
        rings, low = design.telescope.sleeve, -SLEEVE_DROP * height
        bodies += dashes(np.array([0.0, 0.0, low + height]), np.zeros(3))
    else:
        rings, low = () if design.pivot is None else design.pivot.profile, PIN_LIFT * height
        bodies += dashes(np.array([0.0, 0.0, (1.0 + LIFT) * height]), np.array([0.0, 0.0, low]))
    bodies += dashes(np.array([0.0, 0.0, height]), np.array([0.0, 0.0, LIFT * height]))
    layers = [(low + bottom, low + top, base) for bottom, top, base in tubes(rings, axis)]
    bodies.append(Body(*prisms(layers), METAL))
    view = render(bodies, JOINT_PIXEL_MM, EYE)
    middles = {index: middle_of_face(design, index, "p", frame, lifts[index]) for index, frame in frames.items()}
    return numbered(view, middles, JOINT_NUMBER_MM)

"""An object that a person sees at once, and how much of it a shape has."""

from __future__ import annotations

import numpy as np
from PIL import Image, ImageDraw

from riot.geometry.shape import Shape
from riot.types import BoolArray, FloatArray

SIDE = 200
OUTLINE = ((100, 20), (170, 100), (130, 100), (130, 180), (70, 180), (70, 100), (30, 100))


def drawn(outline: object, side: int = SIDE) -> BoolArray:
    """The pixels inside an outline."""
    page = Image.new("1", (side, side))
    ImageDraw.Draw(page).polygon([(x, y) for x, y in np.asarray(outline, dtype=float).tolist()], fill=1)
    return np.asarray(page)


ARROW = drawn(OUTLINE)


def painted(objects: object = (0, 0, 0), page: object = (255, 255, 255)) -> FloatArray:
    """(200, 200, 3) an arrow of one colour on a page; each may be an array of pixels."""
    return np.where(ARROW[..., None], np.asarray(objects, dtype=float), np.asarray(page, dtype=float))


def likeness(shape: Shape, truth: BoolArray = ARROW) -> float:
    """IoU of what was read with the truth."""
    seen = drawn(shape.source(shape.points), len(truth))
    return float((seen & truth).sum() / (seen | truth).sum())

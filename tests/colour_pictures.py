"""Pictures in colour of the shapes of a transform, for tests."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import shapely
from PIL import Image

from pipeline.datasets.item import Item
from riot import Shape, Transform

SIZE = 160


def placed(transform: Transform) -> Transform:
    """The same with both shapes in the middle of a picture."""
    middle = np.array([[50.0, 0.0, 80.0], [0.0, -50.0, 80.0]])
    return replace(transform, p=replace(transform.p, to_source=middle), q=replace(transform.q, to_source=middle.copy()))


def picture(path: Path, shape: Shape, colour: tuple[int, int, int] | None = None, opaque: bool = False) -> Item:
    """A picture of a shape, in one colour or in many; with a transparent background unless opaque."""
    x, y = np.meshgrid(np.arange(SIZE), np.arange(SIZE))
    inside = shapely.contains_xy(shapely.Polygon(shape.source(shape.points)), x.ravel(), y.ravel())
    inside = inside.reshape(SIZE, SIZE)
    rgb = np.stack([x, y, 0 * x], axis=2) if colour is None else np.broadcast_to(colour, (SIZE, SIZE, 3))
    alpha = np.full((SIZE, SIZE, 1), 255) if opaque else 255 * inside[..., None]
    Image.fromarray(np.concatenate([rgb, alpha], axis=2).astype(np.uint8), "RGBA").save(path)
    return Item(path.stem, "", str(path), hashlib.sha256(path.read_bytes()).hexdigest())

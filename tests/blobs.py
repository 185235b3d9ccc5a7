"""Smooth random silhouettes for tests."""

from __future__ import annotations

import numpy as np

from riot import Shape
from riot.groundtruth.pairs import ExactPair
from riot.parameters import ShapeParameters
from riot.types import FloatArray


def blob_polygon(seed: int, waves: int = 5, depth: float = 0.35, count: int = 180) -> FloatArray:
    """A star-shaped polygon, (count, 2), whose radius is a random trigonometric polynomial."""
    rng = np.random.default_rng(seed)
    angle = np.arange(count) * (2.0 * np.pi / count)
    radius = np.ones(count)
    for wave in range(2, waves + 1):
        size = depth * rng.uniform(0.2, 1.0) / wave**0.5
        radius += size * np.cos(wave * angle + rng.uniform(0.0, 2.0 * np.pi))
    radius = np.maximum(radius, 0.25)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)


def blob(seed: int, waves: int = 5, depth: float = 0.35) -> Shape:
    """The shape of a `blob_polygon`."""
    return Shape.from_polygon(blob_polygon(seed, waves, depth), name=f"blob-{seed}")


def pair_shapes(pair: ExactPair) -> tuple[Shape, Shape]:
    """The shapes of an exact pair, with every vertex of its outlines."""
    every = ShapeParameters(feature_tolerance=0.0)
    return Shape.from_polygon(pair.p, "P", every), Shape.from_polygon(pair.q, "Q", every)

"""A collection of any size, grown from real shapes by rotating, mirroring and slightly deforming them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeline.study.waves import deformed
from riot.errors import RiotError
from riot.geometry.shape import Shape
from riot.geometry.silhouette import polygon_shape, read
from riot.scores.trunks import Trunks, quick_trunks
from riot.types import FloatArray

SEED = 2018
AMPLITUDE = 0.03
"""Of all waves together, in units of √area."""

TRIES = 6
"""The amplitude is halved so often before a shape is left undeformed."""


@dataclass(frozen=True)
class Member:
    """Shape ``number`` of a grown collection: variation ``variation`` of a picture, 0 being the picture's own shape."""

    number: int
    path: Path
    variation: int
    amplitude: float = AMPLITUDE


def members(paths: Sequence[Path], count: int, amplitude: float = AMPLITUDE) -> list[Member]:
    """The first ``count`` shapes of the collection: every picture first, evenly spread, then variation by variation.

    A smaller collection is the beginning of a larger one.
    """
    order = _spread(len(paths))
    return [Member(k, paths[order[k % len(order)]], k // len(order), amplitude) for k in range(count)]


def grow(member: Member) -> Shape | None:
    """The shape of a member; None where its picture is refused. The same for the same member, always."""
    try:
        shape = read(member.path)
    except RiotError:
        return None
    if member.variation == 0:
        return shape
    rng = np.random.default_rng([SEED, member.number])
    points = turned(shape.points, rng)
    name = f"{shape.name}~{member.variation}"
    amplitude = member.amplitude
    state = rng.bit_generator.state
    for _ in range(TRIES):
        rng.bit_generator.state = state
        try:
            return polygon_shape(deformed(points, amplitude, rng), name)
        except RiotError:
            amplitude /= 2.0
    return shape


def grown_trunks(member: Member) -> Trunks | None:
    """Quick trunks of a member; None where its picture is refused."""
    shape = grow(member)
    return None if shape is None else quick_trunks(shape)


def turned(points: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Points (m, 2) turned by a random angle, every other time mirrored."""
    angle = rng.uniform(0.0, 2.0 * np.pi)
    cosine, sine = np.cos(angle), np.sin(angle)
    flip = 1.0 if rng.random() < 0.5 else -1.0
    image: FloatArray = points @ np.array([[cosine, sine], [-sine * flip, cosine * flip]])
    return image


def _spread(count: int) -> list[int]:
    """All numbers below ``count`` so that the first of them are spread evenly: by their bits in reverse."""
    bits = max(1, (count - 1).bit_length())
    return sorted(range(count), key=lambda k: f"{k:0{bits}b}"[::-1])

"""Certify a transform: whether its pieces tile both shapes exactly (theory §8). Ours."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from riot.transform.pose import Pose, direction
from riot.transform.transform import Transform
from riot.transform.transform_cache import once_per_transform
from riot.transform.tuning import COVERAGE_TOLERANCE, HINGE_TOLERANCE
from riot.types import FloatArray


@dataclass(frozen=True)
class Assembly:
    """The residuals of one closed chain: areas and lengths of unit-area shapes.

    ``overlap`` = Σ piece areas − area of their union; ``gap`` = area within the outline − area of the union;
    ``hinge`` = greatest distance between two pieces' ends that a hinge joins, the closing one too; ``simple``: the
    outline neither touches nor crosses itself, and no piece does. Where one does, areas are of what it encloses an odd
    number of times (`shapely.make_valid`), and say how far off the assembly is, which fails in any case.
    """

    overlap: float
    gap: float
    hinge: float
    simple: bool

    @property
    def failures(self) -> tuple[str, ...]:
        """Which checks fail, in words."""
        checks = (
            (abs(self.overlap) >= COVERAGE_TOLERANCE, f"pieces overlap by {self.overlap:.2g}"),
            (abs(self.gap) >= COVERAGE_TOLERANCE, f"pieces leave gaps of {self.gap:.2g}"),
            (self.hinge >= HINGE_TOLERANCE, f"hinges miss by {self.hinge:.2g}"),
            (not self.simple, "the outline touches or crosses itself"),
        )
        return tuple(words for failed, words in checks if failed)


@dataclass(frozen=True)
class Certificate:
    """The two assemblies of a transform, verified."""

    p: Assembly
    q: Assembly

    @property
    def passed(self) -> bool:
        """Whether all residuals are within the tolerances of `riot.transform.tuning`, and both outlines are simple."""
        return not self.p.failures and not self.q.failures

    @property
    def failure(self) -> str:
        """Which checks fail, in words; empty if none does."""
        return "; ".join(
            f"{name}: {failure}" for name, assembly in (("P", self.p), ("Q", self.q)) for failure in assembly.failures
        )

    @property
    def residual(self) -> float:
        """The greatest of all area residuals."""
        return max(abs(area) for side in (self.p, self.q) for area in (side.overlap, side.gap))


def certify(transform: Transform) -> Certificate:
    """Verify that the pieces tile P's outline and Q's, with hinges that meet (theory §8).

    Areas are compared as Σ area(piece) − area(∪ piece), never through intersections, which are unreliable between
    polygons that share a noisy edge. Computed once for each transform.

    >>> from riot.groundtruth.pairs import dudeney, exact_transform
    >>> certify(exact_transform(dudeney())).passed
    True
    """
    return _certificate(transform)


@once_per_transform
def _certificate(transform: Transform) -> Certificate:
    return Certificate(
        _assembly(transform, transform.pose(0.0), transform.outline_p()),
        _assembly(transform, transform.pose(1.0), transform.outline_q()),
    )


def _assembly(transform: Transform, pose: Pose, outline: FloatArray) -> Assembly:
    polygons = transform.parts(pose)
    owner = np.repeat(np.arange(len(polygons)), [len(polygon) for polygon in polygons])
    pieces = shapely.polygons(shapely.linearrings(np.concatenate(polygons), indices=owner))
    ring = shapely.linearrings(outline)
    region = shapely.polygons(ring)
    simple = bool(shapely.is_simple(ring)) and bool(shapely.is_valid(pieces).all())
    if not simple:
        pieces, region = shapely.make_valid(pieces), shapely.make_valid(region)
    union = shapely.union_all(pieces).area
    total = float(sum(shapely.area(pieces).tolist()))
    return Assembly(total - union, float(shapely.area(region)) - union, _hinge_error(transform, pose), simple)


def _hinge_error(transform: Transform, pose: Pose) -> float:
    worst = 0.0
    n = len(transform)
    for i, piece in enumerate(transform.pieces):
        end = pose.origins[i] + piece.length * direction(float(pose.headings[i]))
        worst = max(worst, float(np.linalg.norm(end - pose.origins[(i + 1) % n])))
    return worst

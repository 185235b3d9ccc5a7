"""The marks of each picture of a transform, in the shape's own frame (unit area, y up). Ours."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from riot.draw.palette import hue
from riot.draw.piece_image import NO_IMAGES, PieceImages
from riot.draw.scene import Dot, Line, Mark, PlacedPiece, Region
from riot.draw.tuning import SKETCH_TOLERANCE
from riot.geometry.polyline import simplify, simplify_open
from riot.geometry.shape import Shape
from riot.transform.pose import Pose, direction
from riot.transform.transform import Piece, Transform
from riot.types import FloatArray


def sketch(transform: Transform, tolerance: float = SKETCH_TOLERANCE) -> Transform:
    """The transform with the detail that no picture shows left out of its pieces and inputs.

    For pictures only: arcs are simplified piece by piece, so it is not exact any more.

    >>> from riot.groundtruth.pairs import dudeney, exact_transform
    >>> len(sketch(exact_transform(dudeney())))  # pieces
    4
    """
    pieces = tuple(
        Piece(piece.length, _thin(piece.lower, tolerance), _thin(piece.upper, tolerance)) for piece in transform.pieces
    )
    return replace(transform, pieces=pieces)


def input_marks(transform: Transform, side: str) -> list[Mark]:
    """An input with its trunk, every trunk edge in the colour of the piece that will own it; side "p" or "q".

    Of an input that is bent first the trunk lies in the bent outline, a thin line.

    >>> [type(mark).__name__ for mark in input_marks(transform, "p")][:3]
    ['Region', 'Region', 'Line']
    """
    outline, trunk = _cut_shape(transform, side)
    return [*_input(transform, side), *outline_with_trunk(outline, trunk)[1:]]


def outline_with_trunk(outline: FloatArray, trunk: FloatArray) -> list[Mark]:
    """An outline, (m, 2), filled, with a trunk, (n, 2), whose edges have the colours of the pieces in order.

    >>> [mark.pen for mark in outline_with_trunk(house.points, house.points[:3])][:3]
    ['silhouette', 'casing', 'edge0']
    """
    n = len(trunk)
    edges = [np.array([trunk[j], trunk[(j + 1) % n]]) for j in range(n)]
    marks: list[Mark] = [Region((outline,), "silhouette"), Region((trunk,), "casing")]
    marks += [Line(edge, f"edge{hue(j, n)}") for j, edge in enumerate(edges)]
    marks += [Dot(float(x), float(y), "hinge") for x, y in trunk]
    return marks


def thin_outline(shape: Shape) -> FloatArray:
    """The outline of a shape with the detail that no picture shows left out.

    >>> len(thin_outline(house))  # its corners
    5
    """
    kept = simplify(shape.points, SKETCH_TOLERANCE)
    return shape.points[kept] if len(kept) > 2 else shape.points


def deformation_marks(transform: Transform, side: str) -> list[Mark]:
    """The outline that the pieces make, over the input, and over the bent input as a thin line; side "p" or "q".

    >>> [mark.pen for mark in deformation_marks(transform, "p")]
    ['silhouette', 'outline']
    """
    assembled = transform.outline_p() if side == "p" else transform.outline_q()
    return [*_input(transform, side), Region((assembled,), "outline")]


def shown_from_back(transform: Transform, images: PieceImages = NO_IMAGES) -> bool:
    """Whether the hand sees Q on the back of the pieces: because it was mirrored for that, or is painted there.

    >>> shown_from_back(transform)
    False
    """
    return transform.mirrored_q or "q" in images


def ghost_marks(transform: Transform, side: str) -> list[Mark]:
    """An input that is bent first, as it was given, to lie behind the pieces; side "p" or "q".

    >>> ghost_marks(transform, "p")  # nothing is bent
    []
    """
    bend = transform.bend_p if side == "p" else transform.bend_q
    return [] if bend is None else [Region((thin_outline(bend.shape),), "silhouette")]


def dissection_marks(transform: Transform, side: str) -> list[Mark]:
    """The closed chain: P's dissection for side "p", Q's for "q".

    >>> len(dissection_marks(transform, "q"))  # four pieces and four hinges
    8
    """
    return pose_marks(transform, transform.pose(0.0 if side == "p" else 1.0), 0, closed=True, side=side)


def pose_marks(transform: Transform, pose: Pose, open_hinge: int, closed: bool = False, side: str = "p") -> list[Mark]:
    """The pieces in a pose, hinges on top; the open hinge, if it is open, as rings at its two ends.

    ``side`` is the side of the pieces that shows, if they have images.

    >>> len(pose_marks(transform, transform.pose(0.5), 0))  # four pieces, four hinges and the open end
    9
    """
    n = len(transform)
    marks: list[Mark] = [
        PlacedPiece(i, float(pose.origins[i, 0]), float(pose.origins[i, 1]), float(pose.headings[i]), side=side)
        for i in range(n)
    ]
    for i in range(n):
        ring = i == open_hinge and not closed
        marks.append(Dot(float(pose.origins[i, 0]), float(pose.origins[i, 1]), "open" if ring else "hinge"))
    if not closed:
        last = (open_hinge - 1) % n
        x, y = pose.origins[last] + transform.pieces[last].length * direction(float(pose.headings[last]))
        marks.append(Dot(float(x), float(y), "open"))
    return marks


def chain_marks(transform: Transform, open_hinge: int = 0) -> list[Mark]:
    """The chain laid out straight: P's exterior pieces hang below the line, Q's stand above it.

    >>> len(chain_marks(transform)) > len(transform)
    True
    """
    n = len(transform)
    headings, origins = np.zeros(n), np.zeros((n, 2))
    x = 0.0
    for k in range(n):
        i = (open_hinge + k) % n
        origins[i, 0] = x
        x += transform.pieces[i].length
    return pose_marks(transform, Pose(0.5, headings, origins), open_hinge)


def _input(transform: Transform, side: str) -> list[Mark]:
    """An input, and what it is bent to as a line."""
    outline, _ = _cut_shape(transform, side)
    ghost = ghost_marks(transform, side)
    return [*ghost, Region((outline,), "cut")] if ghost else [Region((outline,), "silhouette")]


def _cut_shape(transform: Transform, side: str) -> tuple[FloatArray, FloatArray]:
    shape = transform.p if side == "p" else transform.q
    trunk = transform.trunk_p if side == "p" else transform.trunk_q
    return thin_outline(shape), trunk


def _thin(arc: FloatArray, tolerance: float) -> FloatArray:
    thin: FloatArray = arc[simplify_open(arc, tolerance)]
    return thin

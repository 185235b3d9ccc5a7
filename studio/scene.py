"""What a browser shows of a transform: pieces, how they swing, both inputs, and how alike it makes them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from msgspec import Struct

from riot.draw.keyframes import knots, painting_order
from riot.draw.palette import hue
from riot.geometry.polyline import simplify, simplify_open
from riot.geometry.shape import Shape
from riot.motion.planner import motion_of
from riot.transform.certificate import certify
from riot.transform.deformation import overlap_ratios
from riot.transform.lost_limbs import LostLimb, lost_limbs
from riot.transform.motion import Motion
from riot.transform.transform import Transform
from riot.types import FloatArray
from studio.messages import flat_of

THUMBNAIL = 0.004
"""Douglas–Peucker tolerance of outlines in thumbnails, in the unit-area frame: half a pixel of a picture of 150."""

LEAST_LIMB = 0.03
"""Share of a shape's centre line from which a lost section of it is called a limb, not a tip."""

MOST_PLACES = 3
"""Lost limbs whose places are told."""


class PieceScene(Struct, frozen=True):
    """A piece in its own frame; its first ``lower`` points are P's arc, the rest is Q's."""

    length: float
    outline: list[float]
    lower: int
    colour: int


class MotionScene(Struct, frozen=True):
    """Poses between which headings and middles change evenly; see `riot.draw.keyframes.Knots`."""

    planned: bool
    words: str
    open: int
    lifted: list[int]
    order: list[int]
    times: list[float]
    headings: list[list[float]]
    middles: list[list[float]]
    levels: list[list[float]]


class Fidelity(Struct, frozen=True):
    """How alike the assembled shape is to its input, bent if it is; ``lost`` are the middles of limbs that it lacks."""

    iou: float
    strain: float
    lost: list[float]
    words: str


class SideScene(Struct, frozen=True):
    """One shape: the input, what it is bent to, corners of the trunk, and where it parts the outline."""

    name: str
    input: list[float]
    bent: list[float] | None
    trunk: list[float]
    feet: list[float]
    fidelity: Fidelity


class CertificateScene(Struct, frozen=True):
    """Whether the pieces tile both shapes, and which check fails."""

    passed: bool
    words: str


class Scene(Struct, frozen=True):
    """All that a browser shows of one transform."""

    id: str
    exact: bool
    pieces: list[PieceScene]
    motion: MotionScene
    p: SideScene
    q: SideScene
    words: str
    certificate: CertificateScene


def scene_of(transform: Transform, name: str, *, quick: bool = False) -> Scene:
    """The scene of a transform called ``name``; a ``quick`` one leaves out what is slow to measure.

    The motion is the one that the transform carries, or else an even turn of all hinges.

    >>> scene_of(transform, "1f").words
    '96 % and 96 % alike'
    """
    certificate = certify(transform)
    ious = overlap_ratios(transform)
    sides = {side: _side(transform, side, iou, quick) for side, iou in zip("pq", ious, strict=True)}
    motion = motion_scene(transform)
    words = f"{_percent(ious[0])} and {_percent(ious[1])} alike"
    return Scene(
        id=name,
        exact=certificate.passed,
        pieces=_pieces(transform, 0.0),
        motion=motion,
        **sides,
        words=f"{words}, {motion.words}" if motion.planned else words,
        certificate=CertificateScene(certificate.passed, certificate.failure),
    )


def thumbnail_of(transform: Transform, name: str) -> Scene:
    """A scene with fewer points, for a small picture.

    >>> len(thumbnail_of(transform, "1f").pieces)
    4
    """
    scene = scene_of(transform, name, quick=True)
    return Scene(
        id=name,
        exact=scene.exact,
        pieces=_pieces(transform, THUMBNAIL),
        motion=scene.motion,
        p=_thin(scene.p),
        q=_thin(scene.q),
        words=scene.words,
        certificate=scene.certificate,
    )


def motion_scene(transform: Transform) -> MotionScene:
    """How the pieces swing: as planned, or evenly about the hinge that stays open.

    >>> motion_scene(transform).planned
    False
    """
    motion = even_motion(transform) if transform.plan is None else motion_of(transform)
    poses = knots(motion)
    return MotionScene(
        planned=transform.plan is not None,
        words=motion.words if transform.plan is not None else "",
        open=motion.open_hinge,
        lifted=list(motion.lifted),
        order=painting_order(motion),
        times=np.round(poses.times, 6).tolist(),
        headings=np.round(poses.headings, 6).tolist(),
        middles=np.round(poses.middles, 6).tolist(),
        levels=[motion.levels_at(float(t)).tolist() for t in poses.times],
    )


def even_motion(transform: Transform) -> Motion:
    """All hinges turn evenly and at once: pieces may pass through each other."""
    n = len(transform)
    turns = np.stack([transform.chain.turns(t) for t in (0.0, 1.0)])
    return Motion(
        open_hinge=0,
        lifted=(),
        search="together",
        times=np.array([0.0, 1.0]),
        turns=turns,
        levels=np.zeros((2, n), dtype=np.int64),
        gap=0.0,
        relief=0.0,
        tried=(),
        chain=transform.chain,
        place_p=transform.place_p,
        place_q=transform.place_q,
    )


def _pieces(transform: Transform, tolerance: float) -> list[PieceScene]:
    pieces = []
    for i, piece in enumerate(transform.pieces):
        lower, upper = (_simpler_arc(arc, tolerance) for arc in (piece.lower, piece.upper))
        outline = flat_of(np.concatenate([lower, upper[1:-1]]))
        pieces.append(PieceScene(round(piece.length, 6), outline, len(lower), hue(i, len(transform))))
    return pieces


def _side(transform: Transform, side: str, iou: float, quick: bool) -> SideScene:
    first = side == "p"
    shape: Shape = transform.p if first else transform.q
    given: Shape = transform.input_p if first else transform.input_q
    bend = transform.bend_p if first else transform.bend_q
    outline = transform.outline_p() if first else transform.outline_q()
    lost = None if quick else lost_limbs(outline, shape.points)
    strain = 0.0 if bend is None else bend.rms_strain
    return SideScene(
        name=shape.name,
        input=flat_of(given.points),
        bent=None if bend is None else flat_of(shape.points),
        trunk=flat_of(transform.pose(0.0 if first else 1.0).origins),
        feet=flat_of(transform.trunk_p if first else transform.trunk_q),
        fidelity=Fidelity(
            round(iou, 5),
            round(strain, 5),
            [round(value, 5) for limb in lost or () for value in (limb.x, limb.y)],
            fidelity_words(iou, strain, lost),
        ),
    )


def fidelity_words(iou: float, strain: float, lost: Sequence[LostLimb] | None) -> str:
    """How alike a shape is to its input, and what became of its limbs, for a person; ``lost`` None: not measured.

    >>> fidelity_words(0.95, 0.02, [LostLimb(0.6, -0.5, 0.1)])
    '95 % alike, a limb lost at the lower right, bent by 2.0 %'
    """
    words = [f"{_percent(iou)} alike"]
    if lost is not None:
        limbs = [limb for limb in lost if limb.share >= LEAST_LIMB]
        words.append(_lost(limbs, "limb", "lost") if limbs else _lost(lost, "tip", "blunted"))
    if strain > 0.0:
        words.append(f"bent by {100.0 * strain:.1f} %")
    return ", ".join(words)


def _lost(limbs: Sequence[LostLimb], noun: str, what: str) -> str:
    if not limbs:
        return "every limb kept"
    places = dict.fromkeys(_place(limb) for limb in limbs[:MOST_PLACES])
    return f"{f'a {noun}' if len(limbs) == 1 else f'{len(limbs)} {noun}s'} {what} {' and '.join(places)}"


def _place(limb: LostLimb) -> str:
    """Where a limb is, seen from the centroid."""
    across = "" if abs(limb.x) < 0.4 * abs(limb.y) else "right" if limb.x > 0.0 else "left"
    along = "" if abs(limb.y) < 0.4 * abs(limb.x) else "upper" if limb.y > 0.0 else "lower"
    if across and along:
        return f"at the {along} {across}"
    return f"on the {across}" if across else "at the top" if limb.y > 0.0 else "at the bottom"


def _percent(share: float) -> str:
    return f"{100.0 * share:.0f} %"


def _thin(side: SideScene) -> SideScene:
    return SideScene(side.name, _simpler(side.input), side.bent and _simpler(side.bent), side.trunk, [], side.fidelity)


def _simpler(flat: list[float]) -> list[float]:
    points = np.array(flat).reshape(-1, 2)
    return flat_of(points[simplify(points, THUMBNAIL)], 4)


def _simpler_arc(arc: FloatArray, tolerance: float) -> FloatArray:
    return arc if tolerance == 0.0 or len(arc) < 3 else arc[simplify_open(arc, tolerance)]

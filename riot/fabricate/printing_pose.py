"""The pose in which a chain is printed in place: one of its motion, that fits the bed, with its pieces apart. Ours."""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np
import shapely

from riot.errors import FabricationError
from riot.fabricate.clearance import make_regions, pair_gaps
from riot.fabricate.model import PieceDesign, Placement
from riot.fabricate.pivot import knuckle_radius
from riot.fabricate.sub_chains import sub_chain_at, sub_chains
from riot.fabricate.tuning import BED_SPACE_MM, IN_PLACE_APART_MM, IN_PLACE_POSES
from riot.parameters import FabricationParameters
from riot.transform.motion import Motion
from riot.types import FloatArray


def printing_pose(
    pieces: tuple[PieceDesign, ...], motion: Motion, parameters: FabricationParameters, scale: float
) -> Placement:
    """Among poses that fit the bed the smallest with pieces well apart, or else the one with them furthest apart.

    Raises `riot.errors.FabricationError` ``bed`` if no pose fits.
    """
    times = np.linspace(0.0, 1.0, IN_PLACE_POSES)
    apart = _least_gaps(pieces, motion, scale, times)
    poses = [Placement(float(t), *_box(pieces, motion, scale, t), gap) for t, gap in zip(times, apart, strict=True)]
    width, depth = parameters.bed_width_mm - 2 * BED_SPACE_MM, parameters.bed_depth_mm - 2 * BED_SPACE_MM
    long, short = max(width, depth), min(width, depth)
    fitting = [pose for pose in poses if pose.width <= long and pose.depth <= short]
    if not fitting:
        nearest = min(poses, key=lambda pose: max(pose.width / long, pose.depth / short))
        hinges = 2.0 * knuckle_radius(parameters)  # which stay as large as they are
        share = min((long - hinges) / (nearest.width - hinges), (short - hinges) / (nearest.depth - hinges), 1.0)
        raise FabricationError(
            "bed",
            f"the chain is {nearest.width:.0f} × {nearest.depth:.0f} mm in the pose of its motion that is nearest to "
            f"fitting, the bed {parameters.bed_width_mm:g} × {parameters.bed_depth_mm:g} mm: lessen size_mm "
            f"({parameters.size_mm:g}) to about {math.floor(share * parameters.size_mm)}, tell of a larger bed "
            "(bed_width_mm, bed_depth_mm), or choose another pivot than in-place",
            "bed_width_mm",
        )
    enough = min(IN_PLACE_APART_MM, max(pose.gap for pose in fitting))
    return min((pose for pose in fitting if pose.gap >= enough), key=lambda pose: pose.width * pose.depth)


def refuse_lifts(motion: Motion) -> None:
    """Raise `riot.errors.FabricationError` ``telescopic`` if the motion lifts pieces."""
    if motion.lifted:
        raise FabricationError(
            "telescopic",
            f"pivot: hinges {', '.join(map(str, motion.lifted))} must lift, and a telescopic hinge is put together by "
            "hand: choose another pivot than in-place, or take another transform (--pieces, --rank)",
        )


def _least_gaps(pieces: tuple[PieceDesign, ...], motion: Motion, scale: float, times: FloatArray) -> list[float]:
    """The least gap of two pieces at every time, hinged ones outside the room of their hinge, mm."""
    (whole,) = sub_chains(motion, scale)
    chain = sub_chain_at(motion, scale, whole.pieces, times)
    members = [pieces[i] for i in whole.pieces.tolist()]
    ends = [(piece.start, piece.end) for piece in members]
    regions = make_regions([piece.footprint for piece in members], ends, [piece.length for piece in members])
    pairs = combinations(range(len(members)), 2)
    least: FloatArray = np.min([pair_gaps(chain, regions, i, j) for i, j in pairs], axis=0)
    return [float(gap) for gap in least]


def _box(pieces: tuple[PieceDesign, ...], motion: Motion, scale: float, t: float) -> tuple[float, float, float]:
    """By what to turn the pose, radians, and how long and deep the least box around it is then, mm."""
    pose = motion.pose_at(float(t))
    placed = []
    for piece, heading, origin in zip(pieces, pose.headings, scale * pose.origins, strict=True):
        points = shapely.get_coordinates(piece.footprint.convex_hull)
        c, s = math.cos(heading), math.sin(heading)
        placed.append(points @ np.array([[c, s], [-s, c]]) + origin)
    hull = shapely.get_coordinates(shapely.MultiPoint(np.concatenate(placed)).convex_hull)
    edges = np.diff(hull, axis=0)
    boxes = []
    for angle in np.arctan2(edges[:, 1], edges[:, 0]).tolist():
        c, s = math.cos(angle), math.sin(angle)
        wide, deep = np.ptp(hull @ np.array([[c, -s], [s, c]]), axis=0).tolist()
        turn = -angle if wide >= deep else 0.5 * math.pi - angle
        boxes.append((max(wide, deep) * min(wide, deep), turn, max(wide, deep), min(wide, deep)))
    _, turn, long, short = min(boxes)
    return turn, long, short

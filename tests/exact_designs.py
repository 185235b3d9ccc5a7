"""Designs of exact transforms, made once: what tests of fabrication build on. Pair (0, 0) is Dudeney's."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np

from riot import Transform
from riot.fabricate import Design, FabricationParameters, PieceDesign, design
from riot.groundtruth.pairs import dudeney, exact_pair, exact_transform
from riot.motion.planner import plan_motion
from riot.parameters import MotionParameters
from riot.transform.motion import LIFT, Motion

PAIRS = ((3, 1), (5, 1), (6, 2))
LIFTED_MM = 150.0


@cache
def transform_of(n: int, seed: int) -> Transform:
    return exact_transform(dudeney() if n == 0 else exact_pair(n, seed))


@cache
def design_of(n: int, seed: int) -> Design:
    return design(transform_of(n, seed))


def lifting(transform: Transform) -> Transform:
    """The same with a plan that lifts at one hinge though it need not: the second from the open one."""
    flat = plan_motion(transform, MotionParameters(gap=0.35 / LIFTED_MM, relief=3.8 / LIFTED_MM))
    n = len(transform)
    lifted = (flat.open_hinge + 2) % n
    level = np.zeros(n, dtype=np.int64)
    level[(lifted + np.arange((flat.open_hinge - lifted - 1) % n + 1)) % n] = 1
    ground = np.zeros((1, n), dtype=np.int64)
    plan = Motion(
        flat.open_hinge,
        (lifted,),
        flat.search,
        np.concatenate([[0.0], LIFT + (1.0 - 2.0 * LIFT) * flat.times, [1.0]]),
        np.concatenate([flat.turns[:1], flat.turns, flat.turns[-1:]]),
        np.concatenate([ground, np.tile(level, (len(flat.times), 1)), ground]),
        flat.gap,
        flat.relief,
        flat.tried,
        flat.chain,
        flat.place_p,
        flat.place_q,
    )
    return replace(transform, plan=plan)


@cache
def lifted_design() -> Design:
    return design(lifting(transform_of(4, 2)), FabricationParameters(size_mm=LIFTED_MM))


def designs() -> list[Design]:
    return [design_of(0, 0), *(design_of(*pair) for pair in PAIRS), lifted_design()]


def with_piece(puzzle_design: Design, index: int, changed: Callable[[PieceDesign], PieceDesign]) -> Design:
    pieces = tuple(changed(piece) if i == index else piece for i, piece in enumerate(puzzle_design.pieces))
    return replace(puzzle_design, pieces=pieces)

"""What makes the weak places of a puzzle strong: sizes with which it has been built and passes, if any. Ours."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from riot.errors import FabricationError
from riot.fabricate.certificate import certify
from riot.fabricate.design import design, is_weak, strong_width
from riot.fabricate.model import Design
from riot.fabricate.plates import check_bed
from riot.fabricate.tuning import GREATEST_WALL_MM, SIZE_FACTOR, WALL_STEP_MM
from riot.parameters import FabricationParameters, allowed_range
from riot.transform.transform import Transform


def strengthening(puzzle: Design) -> str:
    """In words: with which thicker walls, or else which larger size, no place is weak; empty if none is.

    What is told has been designed anew and passes its certificate.
    """
    if not any(is_weak(piece, puzzle.parameters) for piece in puzzle.pieces):
        return ""
    wanted = strong_width(puzzle.parameters)
    for name, candidates in (("wall_mm", _walls(puzzle.parameters)), ("size_mm", _sizes(puzzle))):
        found = _least_strong(puzzle.transform, candidates)
        if found is not None:
            return f"no place is narrower than {wanted:g} mm with {name}={getattr(found, name):g}"
    return f"no wall and no size up to that of the bed makes every place {wanted:g} mm wide: handle it with care"


def _least_strong(transform: Transform, candidates: Sequence[FabricationParameters]) -> FabricationParameters | None:
    """The first of ascending candidates that is strong and passes, by halving, or None."""
    low, high = -1, len(candidates) - 1
    best = _strong(transform, candidates[high]) if candidates else None
    if best is None:
        return None
    while high - low > 1:
        middle = (low + high) // 2
        stronger = _strong(transform, candidates[middle])
        low, high, best = (low, middle, stronger) if stronger else (middle, high, best)
    return candidates[high] if best and certify(best).passed else None


def _strong(transform: Transform, parameters: FabricationParameters) -> Design | None:
    """The design with these parameters, if it can be made and no place is weak."""
    try:
        stronger = design(transform, parameters)
    except FabricationError:
        return None
    return None if any(is_weak(piece, parameters) for piece in stronger.pieces) else stronger


def _walls(parameters: FabricationParameters) -> list[FabricationParameters]:
    count = int((GREATEST_WALL_MM - parameters.wall_mm) / WALL_STEP_MM + 1e-9)
    return [replace(parameters, wall_mm=round(parameters.wall_mm + WALL_STEP_MM * (k + 1), 3)) for k in range(count)]


def _sizes(puzzle: Design) -> list[FabricationParameters]:
    """Larger sizes whose pieces fit on the bed."""
    parameters, sizes = puzzle.parameters, list[FabricationParameters]()
    greatest = allowed_range(FabricationParameters, "size_mm")[1]
    while (size := round(SIZE_FACTOR * parameters.size_mm)) <= greatest:
        parameters = replace(parameters, size_mm=float(size))
        try:
            check_bed(puzzle.transform, parameters)
        except FabricationError:
            break
        sizes.append(parameters)
    return sizes

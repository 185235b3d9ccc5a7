"""The certificate of a puzzle that is to be made, and how a puzzle that fails can be mended. Ours.

What it proves: every part is one closed solid that prints without supports; at every hinge the pin is held by what is
asked for, has its clearance where it turns, and keeps the pieces from being pulled apart; magnets go into their pockets
and meet face to face; no piece is hardly more than its hinges; and all pieces keep the outline gap between them at
every moment of the planned motion, at every height, not only at sampled poses. Solids are cut with each other at some
poses besides, which catches errors in how they were made.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from riot.errors import FabricationError
from riot.fabricate.design import design
from riot.fabricate.hinge_check import check_hinges
from riot.fabricate.hinge_record import HingeCheck
from riot.fabricate.in_place import PlacementCheck, check_placement
from riot.fabricate.magnet_check import MagnetCheck, check_magnets
from riot.fabricate.model import Design
from riot.fabricate.motion_check import MotionCheck, check_motion
from riot.fabricate.part_check import PartCheck, check_part, refuse_large_hinges, thinner_pin
from riot.fabricate.solid import Part, make_parts
from riot.fabricate.tuning import GREATEST_WALL_MM, SIZE_FACTOR, WALL_STEP_MM
from riot.parameters import FabricationParameters, allowed_range
from riot.transform.transform import Transform

MENDED = ("size_mm", "pin_mm", "pivot", "wall_mm")
"""What `fix` may change."""


@dataclass(frozen=True)
class FabricationCertificate:
    """The checks of a design and its solids, and their results."""

    parts: tuple[PartCheck, ...]
    hinges: tuple[HingeCheck, ...]
    motion: MotionCheck
    placement: PlacementCheck | None = None
    magnets: tuple[MagnetCheck, ...] = ()

    @property
    def failures(self) -> tuple[str, ...]:
        """Messages of the checks that fail: each names the part or hinge, the pose, and the parameter that mends it."""
        checks = (*self.parts, *self.hinges, *self.magnets, self.motion, self.placement)
        return tuple(words for check in checks if check is not None for words in check.failures)

    @property
    def passed(self) -> bool:
        """Whether no check fails."""
        return not self.failures

    @property
    def wall(self) -> float:
        """Least width of all pieces, mm."""
        return min(check.wall for check in self.parts if not math.isnan(check.wall))

    @property
    def hinge_share(self) -> float:
        """The greatest share of a piece's area that its hinges take."""
        return max(check.hinge_share for check in self.parts if not math.isnan(check.hinge_share))

    @property
    def supported(self) -> bool:
        """Whether every part prints without supports."""
        return not any(check.supports.failures for check in self.parts)

    @property
    def overhang(self) -> float:
        """The greatest lean of a layer over the one below, degrees."""
        return max(check.supports.overhang for check in self.parts)

    @property
    def bridge(self) -> float:
        """The longest bridge, mm; 0 if there is none."""
        return max(check.supports.bridge for check in self.parts)

    def words(self) -> list[str]:
        """Describe each hinge and the motion, one line for each."""
        lines = [check.words for check in self.hinges] + [check.words for check in self.magnets]
        lines.append(
            f"prints without supports: overhangs up to {self.overhang:.0f}°, "
            f"{f'bridges up to {self.bridge:.1f} mm' if self.bridge else 'no bridges'}"
            if self.supported
            else "does not print without supports"
        )
        lines.append(f"hinges are at most {self.hinge_share:.0%} as large as their piece")
        motion = self.motion
        proof = f"proven at every moment ({motion.examined} poses of two pieces)" if motion.proven else "not proven"
        lines.append(f"motion: pieces keep {motion.floor:.3f} mm apart, {proof}; least gap found {motion.gap:.3f} mm")
        if self.placement is not None:
            lines.append(
                f"printed in place: {self.placement.solids} solids on the bed, {self.placement.gap:.3f} mm apart or "
                f"more, {self.placement.common:.2g} mm³ in common at most"
            )
        lines.append(f"solids cut with each other at {motion.poses} poses: {motion.overlap:.2g} mm³ in common at most")
        return lines


def certify(design: Design, parts: tuple[Part, ...] | None = None) -> FabricationCertificate:
    """Verify a design and its solids; without ``parts`` make its solids first."""
    parts = make_parts(design) if parts is None else parts
    return FabricationCertificate(
        tuple(check_part(part, design) for part in parts),
        check_hinges(design, parts),
        check_motion(design, parts),
        None if design.placement is None else check_placement(design, parts),
        check_magnets(design, parts),
    )


@dataclass(frozen=True, eq=False)
class BuiltPuzzle:
    """A design with its solids and their certificate, and the parameters that `fix` changed, in words."""

    design: Design
    parts: tuple[Part, ...]
    certificate: FabricationCertificate
    changes: tuple[str, ...] = ()


def build(transform: Transform, parameters: FabricationParameters | None = None) -> BuiltPuzzle:
    """Design, build and verify a puzzle with exactly these parameters; its certificate may fail.

    Raises `riot.errors.FabricationError` for what cannot exist.
    """
    puzzle_design = design(transform, parameters)
    parts = make_parts(puzzle_design)
    return BuiltPuzzle(puzzle_design, parts, certify(puzzle_design, parts))


def fix(transform: Transform, parameters: FabricationParameters | None = None, *, enlarge: bool = True) -> BuiltPuzzle:
    """Design, build and verify; thin the pin, enlarge the size or thicken knuckles, as allowed, until it passes.

    Without ``enlarge`` the size stays as it is.

    Raises the `riot.errors.FabricationError` of the last try if nothing helps; its message says what was
    tried.
    """
    asked = parameters or FabricationParameters()
    tried = asked
    while True:
        try:
            puzzle_design = design(transform, tried)
            refuse_large_hinges(puzzle_design)
            parts = make_parts(puzzle_design)
            puzzle = BuiltPuzzle(puzzle_design, parts, certify(puzzle_design, parts))
            if puzzle.certificate.passed:
                return replace(puzzle, changes=_changes(asked, tried))
            failed = [check for check in puzzle.certificate.parts if check.failures]
            first = max(failed, key=lambda check: (check.mend == "size_mm", check.value), default=None)
            mend, value = ("size_mm", math.nan) if first is None else (first.mend, first.value)
            error = FabricationError("uncertified", "; ".join(puzzle.certificate.failures), mend, value)
        except FabricationError as caught:
            error = caught
        following = _next(tried, error, enlarge) if error.parameter in MENDED else None
        if following is None:
            raise _hopeless(error, _changes(asked, tried)) from error
        tried = following


def way_out(transform: Transform, parameters: FabricationParameters) -> str:
    """What would make a puzzle that fails: parameters with which it has been built and passes; or that nothing does.

    What is printed in place may pass with printed pins where nothing else mends it.
    """
    fewer = "a transform of fewer pieces (riot make --pieces) has larger ones"
    try:
        return f"it passes with {', '.join(fix(transform, parameters).changes)} (--fix); {fewer}"
    except FabricationError:
        pass
    if parameters.pivot == "in-place":
        try:
            puzzle = fix(transform, replace(parameters, pivot="printed"))
            return f"it passes with {', '.join(_changes(parameters, puzzle.design.parameters))}; {fewer}"
        except FabricationError:
            pass
    return "no size, pin or wall mends it: take another transform (--rank, --pieces)"


def _next(tried: FabricationParameters, error: FabricationError, enlarge: bool) -> FabricationParameters | None:
    """Return the parameters to try next, or None if none is left.

    Where a knuckle hangs on little its wall is thickened: no size widens a narrow corner. Else the pin comes first,
    which keeps the size that was asked for.
    """
    if error.parameter == "wall_mm":
        wall = round(tried.wall_mm + WALL_STEP_MM, 3)
        return replace(tried, wall_mm=wall) if wall <= GREATEST_WALL_MM else None
    thin = thinner_pin(tried)
    if thin is not None:
        return thin
    greatest = allowed_range(FabricationParameters, "size_mm")[1]
    if not enlarge or tried.size_mm >= greatest:
        return None
    wished = (
        error.value if error.parameter == "size_mm" and error.value > tried.size_mm else SIZE_FACTOR * tried.size_mm
    )
    return replace(tried, size_mm=float(min(greatest, math.ceil(wished))))


def _hopeless(error: FabricationError, changes: tuple[str, ...]) -> FabricationError:
    """Return the error of the last try with the changes that were tried."""
    if not changes:
        return error
    message = f"{error} (tried with {', '.join(changes)})"
    return FabricationError(error.reason, message, error.parameter, error.value)


def _changes(asked: FabricationParameters, used: FabricationParameters) -> tuple[str, ...]:
    return tuple(
        f"{name}: {_value(getattr(used, name))} instead of {_value(getattr(asked, name))}"
        for name in MENDED
        if getattr(used, name) != getattr(asked, name)
    )


def _value(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:g}"

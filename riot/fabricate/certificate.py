"""The certificate of a puzzle that is to be made, and how a puzzle that fails can be mended. Ours.

What it proves: every part is one closed solid; at every hinge the pin has the clearance asked for; and all pieces keep
the outline gap between them at every moment of the planned motion, at every height, not only at sampled poses. Solids
are cut with each other at some poses besides, which catches errors in how they were made.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from rich.table import Table

from riot.errors import FabricationError
from riot.fabricate.checks import HingeCheck, MotionCheck, PartCheck, check_hinges, check_motion, check_part
from riot.fabricate.design import design
from riot.fabricate.model import Design
from riot.fabricate.solid import Part, make_parts
from riot.parameters import FabricationParameters, allowed_range
from riot.transform.transform import Transform

LARGER = 1.25
"""A size is enlarged by this factor at a time if nothing tells how much is enough."""

THIN_PIN = 1.75
"""Diameter of the filament that serves as a thinner pin, mm."""

WALL_STEP, THICKEST_WALL = 0.6, 4.0
"""Knuckles' walls are thickened by so much at a time, and up to this, mm."""

MENDED = ("size_mm", "pin_mm", "wall_mm")
"""What `fix` may change."""


@dataclass(frozen=True)
class FabricationCertificate:
    """What was verified of a design and its solids."""

    parts: tuple[PartCheck, ...]
    hinges: tuple[HingeCheck, ...]
    motion: MotionCheck

    @property
    def failures(self) -> tuple[str, ...]:
        """Which checks fail, in words: the part or the hinge, the pose, and the parameter that would mend it."""
        said = [check.failures for check in self.parts] + [check.failures for check in self.hinges]
        return tuple(words for each in (*said, self.motion.failures) for words in each)

    @property
    def passed(self) -> bool:
        """Whether none fails."""
        return not self.failures

    @property
    def wall(self) -> float:
        """The narrowest of all pieces, mm."""
        return min(check.wall for check in self.parts if not math.isnan(check.wall))

    def table(self) -> Table:
        """For the terminal: a row a part, then the hinges, then the motion."""
        table = Table(
            "part",
            "count",
            "solids",
            "handles",
            "volume cm³",
            "narrowest mm",
            title="Fabrication",
            title_justify="left",
        )
        for check in self.parts:
            table.add_row(
                check.name,
                str(check.count),
                str(check.components),
                str(check.genus),
                f"{check.volume / 1000.0:.3f}",
                "" if math.isnan(check.wall) else f"{check.wall:.2f}",
            )
        return table

    def words(self) -> list[str]:
        """The hinges and the motion, a line each."""
        said = [
            f"hinge {check.hinge}: {check.kind}, {check.axial_gap:.2f} mm along the axis, "
            f"{check.male_gap:.2f} and {check.female_gap:.2f} mm around it"
            for check in self.hinges
        ]
        motion = self.motion
        proof = f"proven at every moment ({motion.looked} poses of two pieces)" if motion.proven else "not proven"
        said.append(f"motion: pieces keep {motion.floor:.3f} mm apart, {proof}; least gap found {motion.gap:.3f} mm")
        said.append(f"solids cut with each other at {motion.poses} poses: {motion.overlap:.2g} mm³ in common at most")
        return said


def certify(design: Design, parts: tuple[Part, ...] | None = None) -> FabricationCertificate:
    """Verify a design and its solids (`riot.fabricate.solid.make_parts`; made now without ``parts``)."""
    parts = make_parts(design) if parts is None else parts
    pieces = {piece.name: piece for piece in design.pieces}
    return FabricationCertificate(
        tuple(check_part(part, pieces.get(part.name)) for part in parts),
        check_hinges(design, parts),
        check_motion(design, parts),
    )


@dataclass(frozen=True, eq=False)
class Built:
    """A design with its solids and their certificate, and what `fix` changed of the parameters asked for, in words."""

    design: Design
    parts: tuple[Part, ...]
    certificate: FabricationCertificate
    changes: tuple[str, ...] = ()


def build(transform: Transform, parameters: FabricationParameters | None = None) -> Built:
    """Design, build and verify with just these parameters; the certificate of what comes back may fail.

    Raises `riot.errors.FabricationError` for what cannot exist.
    """
    made = design(transform, parameters)
    parts = make_parts(made)
    return Built(made, parts, certify(made, parts))


def fix(transform: Transform, parameters: FabricationParameters | None = None, *, enlarge: bool = True) -> Built:
    """Design, build and verify; thin the pin, enlarge the size or thicken knuckles, as allowed, until it passes.

    Without ``enlarge`` the size stays as it is.

    Raises the `riot.errors.FabricationError` of the last try if nothing helps; its message says what was
    tried.
    """
    asked = parameters or FabricationParameters()
    tried = asked
    while True:
        try:
            made = build(transform, tried)
            if made.certificate.passed:
                return replace(made, changes=_changes(asked, tried))
            mend = next((check.mend for check in made.certificate.parts if check.failures), "size_mm")
            error = FabricationError("uncertified", "; ".join(made.certificate.failures), mend)
        except FabricationError as caught:
            error = caught
        following = _next(tried, error, enlarge) if error.parameter in MENDED else None
        if following is None:
            raise _hopeless(error, _changes(asked, tried)) from error
        tried = following


def _next(tried: FabricationParameters, error: FabricationError, enlarge: bool) -> FabricationParameters | None:
    """What to try next; None if all is tried.

    Where a knuckle hangs on little its wall is thickened: no size widens a narrow corner. Else the pin comes first,
    which keeps the size that was asked for.
    """
    if error.parameter == "wall_mm":
        wall = round(tried.wall_mm + WALL_STEP, 3)
        return replace(tried, wall_mm=wall) if wall <= THICKEST_WALL else None
    if tried.pin_mm > THIN_PIN:
        return replace(tried, pin_mm=THIN_PIN)
    greatest = allowed_range(FabricationParameters, "size_mm")[1]
    if not enlarge or tried.size_mm >= greatest:
        return None
    wished = error.value if error.parameter == "size_mm" and error.value > tried.size_mm else LARGER * tried.size_mm
    return replace(tried, size_mm=float(min(greatest, math.ceil(wished))))


def _hopeless(error: FabricationError, changes: tuple[str, ...]) -> FabricationError:
    """The error of the last try with what was tried before it."""
    if not changes:
        return error
    said = f"{error} (tried with {', '.join(changes)})"
    return FabricationError(error.reason, said, error.parameter, error.value)


def _changes(asked: FabricationParameters, made: FabricationParameters) -> tuple[str, ...]:
    return tuple(
        f"{name}: {getattr(made, name):g} instead of {getattr(asked, name):g}"
        for name in MENDED
        if getattr(made, name) != getattr(asked, name)
    )

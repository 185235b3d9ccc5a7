"""Transform: a RIOT as n rigid pieces in a chain; everything else follows from them by rigid motion (theory §1, §8).

Piece i owns trunk edge ``e_i``. In the piece's own frame the edge lies on the x-axis from (0, 0) to (length, 0);
below hangs P's exterior piece i, above it stands Q's. Hinge j joins piece j−1 to piece j; hinge 0 closes the chain.
"""

from __future__ import annotations

import math
import os
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from riot.geometry.shape import Shape
from riot.transform.pose import Chain, Placement, Pose, swing
from riot.types import FloatArray

if TYPE_CHECKING:
    from riot.motion import Motion
    from riot.transform.certificate import Certificate, Deformation
    from riot.transform.history import History


@dataclass(frozen=True, eq=False)
class Piece:
    """One rigid piece, in its own frame.

    Parameters
    ----------
    length : float
        Length of its trunk edge.
    lower : (k, 2) float64
        P's boundary arc, from (0, 0) to (length, 0), y ≤ 0: the edge itself if the exterior piece is empty.
    upper : (l, 2) float64
        Q's boundary arc, from (length, 0) back to (0, 0), y ≥ 0.
    """

    length: float
    lower: FloatArray
    upper: FloatArray

    @property
    def polygon(self) -> FloatArray:
        """(k + l − 2, 2) the piece's whole outline, counter-clockwise, each point once."""
        return np.concatenate([self.lower[:-1], self.upper[:-1]])


@dataclass(frozen=True, eq=False)
class Transform:
    """An exact reversible transform of P into Q.

    Parameters
    ----------
    pieces : tuple of Piece
        In chain order, n ≥ 3.
    angles : (n,) float64
        Trunk angles α_j of T at hinge j (the start of edge j), radians; T is listed counter-clockwise.
    conjugate_angles : (n,) float64
        Trunk angles of T̄ at the same hinges.
    place_p, place_q : Placement
        Of piece 0 in P's frame when the chain is closed as P, and in Q's when it is closed as Q.
    p, q : Shape
        The inputs.
    trunk_p, trunk_q : (n, 2) float64
        Where the inputs' arcs part: the boundary points nearest to the trunks' corners, in corresponding order,
        ``trunk_p`` counter-clockwise, ``trunk_q`` clockwise.
    bound_p, bound_q : float
        The highest IoU with the inputs that an exact construction on these conjugate trunks can have (theory §8).
    plan : Motion, optional
        How the pieces swing, where that is planned already; see `motion`.
    history : History, optional
        From which pictures, by which parameters, code and libraries it was made.
    """

    pieces: tuple[Piece, ...]
    angles: FloatArray
    conjugate_angles: FloatArray
    place_p: Placement
    place_q: Placement
    p: Shape
    q: Shape
    trunk_p: FloatArray
    trunk_q: FloatArray
    bound_p: float = math.nan
    bound_q: float = math.nan
    plan: Motion | None = None
    history: History | None = None

    def __len__(self) -> int:
        return len(self.pieces)

    @cached_property
    def chain(self) -> Chain:
        """Edge lengths and trunk angles."""
        return Chain(np.array([piece.length for piece in self.pieces]), self.angles, self.conjugate_angles)

    def pose(self, t: float, open_hinge: int = 0) -> Pose:
        """The chain at time t: 0 is P in P's frame, 1 is Q in Q's; between them every hinge turns evenly.

        The chain is open at ``open_hinge``. Pieces may collide on the way: see `motion` for a way on which they do not.
        Ours.
        """
        if open_hinge == 0 and t in (0.0, 1.0):
            return self._closed_q if t else self._closed_p
        return swing(self.chain, self.place_p, self.place_q, t, open_hinge)

    @cached_property
    def _closed_p(self) -> Pose:
        return swing(self.chain, self.place_p, self.place_q, 0.0)

    @cached_property
    def _closed_q(self) -> Pose:
        return swing(self.chain, self.place_p, self.place_q, 1.0)

    def motion(self) -> Motion:
        """How the pieces swing from P to Q without collision: ``plan``, or planned now with default parameters, once.

        See `riot.motion.Motion`; `planned` keeps the result.
        """
        return self._motion if self.plan is None else self.plan

    @cached_property
    def _motion(self) -> Motion:
        from riot.motion import plan_motion

        return plan_motion(self)

    def planned(self) -> Transform:
        """The transform with its motion as ``plan``, to be saved with it."""
        return replace(self, plan=self.motion())

    def parts(self, pose: Pose) -> list[FloatArray]:
        """The n pieces' polygons in a pose, counter-clockwise, each point once."""
        return [pose.place(i, piece.polygon) for i, piece in enumerate(self.pieces)]

    def outline_p(self) -> FloatArray:
        """(m, 2) outline of the assembled P, counter-clockwise, in P's frame."""
        pose = self.pose(0.0)
        return np.concatenate([pose.place(i, piece.lower[:-1]) for i, piece in enumerate(self.pieces)])

    def outline_q(self) -> FloatArray:
        """(m, 2) outline of the assembled Q, counter-clockwise, in Q's frame."""
        pose = self.pose(1.0)
        chain = reversed(list(enumerate(self.pieces)))
        return np.concatenate([pose.place(i, piece.upper[:-1]) for i, piece in chain])

    def certificate(self) -> Certificate:
        """Verify the two assemblies, once; see `riot.transform.certificate.Certificate`."""
        return self._certificate

    @cached_property
    def _certificate(self) -> Certificate:
        from riot.transform.certificate import certify

        return certify(self)

    @cached_property
    def overlap_ratios(self) -> tuple[float, float]:
        """IoU of the assembled P with P, and of the assembled Q with Q."""
        from riot.transform.certificate import overlap_ratio

        return overlap_ratio(self.outline_p(), self.p.points), overlap_ratio(self.outline_q(), self.q.points)

    def deformation(self) -> Deformation:
        """Compare the two assemblies with the inputs; see `riot.transform.certificate.Deformation`."""
        from riot.transform.certificate import measure

        return measure(self)

    def draw(self, path: str | os.PathLike[str]) -> None:
        """Draw inputs, trunks, both dissections and the chain; the suffix (svg, png, pdf) chooses the format."""
        from riot.draw import draw_transform

        draw_transform(self, path)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a ``.riot`` file: JSON, exact to the last bit; `load` reads it back equal."""
        from riot.transform.riot_file import save

        save(self, path)

    @staticmethod
    def load(path: str | os.PathLike[str]) -> Transform:
        """Read a ``.riot`` file; raises `riot.errors.FormatError` if it is none, or of an unknown version."""
        from riot.transform.riot_file import load

        return load(path)

"""Transform: a RIOT as n rigid pieces in a chain; everything else follows from them by rigid motion (theory §1, §8).

A transform is data. What is computed from it is a function: `riot.transform.certificate.certify`,
`riot.transform.deformation.measure_deformation`, `riot.motion.planner.plan_motion`, `riot.draw.figure.draw_transform`,
`riot.transform.riot_file.save`. `riot.methods` attaches them as methods for users of ``riot.Transform``.

Piece i owns trunk edge ``e_i``. In the piece's own frame the edge lies on the x-axis from (0, 0) to (length, 0);
below hangs P's exterior piece i, above it stands Q's. Hinge j joins piece j−1 to piece j; hinge 0 closes the chain.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from riot.content import ByContent, count
from riot.geometry.shape import Shape
from riot.transform.pose import Chain, Placement, Pose, swing
from riot.types import FloatArray

if TYPE_CHECKING:  # a transform computes nothing with them: what makes one does not depend on their code
    from riot.geometry.bend import Bend
    from riot.transform.history import History
    from riot.transform.motion import Motion


@dataclass(frozen=True, eq=False)
class Piece(ByContent):
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

    def __repr__(self) -> str:
        return f"Piece({self.length:.3g} long, {len(self.lower)} + {len(self.upper)} points)"

    @property
    def polygon(self) -> FloatArray:
        """(k + l − 2, 2) the piece's whole outline, counter-clockwise, each point once."""
        return np.concatenate([self.lower[:-1], self.upper[:-1]])


@dataclass(frozen=True, eq=False)
class Transform(ByContent):
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
        What is cut: the inputs, or what they were bent to.
    trunk_p, trunk_q : (n, 2) float64
        Where their arcs part: the boundary points nearest to the trunks' corners, in corresponding order,
        ``trunk_p`` counter-clockwise, ``trunk_q`` clockwise.
    bound_p, bound_q : float
        The highest IoU with them that an exact construction on these conjugate trunks can have (theory §8).
    plan : Motion, optional
        How the pieces swing, where that is planned already.
    history : History, optional
        From which pictures, by which parameters, code and libraries it was made.
    bend_p, bend_q : Bend, optional
        What was done to the inputs before they were cut; ``bend_p.bent`` is ``p``.
    mirrored_q : bool
        Q is the mirror image of what was given: the puzzle shows it the right way when it is turned over.
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
    bend_p: Bend | None = None
    bend_q: Bend | None = None
    mirrored_q: bool = False

    def __repr__(self) -> str:
        return f"Transform({self.p.name!r} ⇄ {self.q.name!r}, {count(len(self), 'piece')})"

    def __len__(self) -> int:
        return len(self.pieces)

    @property
    def input_p(self) -> Shape:
        """P as it was given, before it was bent.

        >>> transform.input_p is transform.p  # nothing was bent
        True
        """
        return self.p if self.bend_p is None else self.bend_p.shape

    @property
    def input_q(self) -> Shape:
        """Q as it was given, before it was bent.

        >>> transform.input_q is transform.q
        True
        """
        return self.q if self.bend_q is None else self.bend_q.shape

    @cached_property
    def chain(self) -> Chain:
        """Edge lengths and trunk angles."""
        return Chain(np.array([piece.length for piece in self.pieces]), self.angles, self.conjugate_angles)

    def pose(self, t: float, open_hinge: int = 0) -> Pose:
        """The chain at time t: 0 is P in P's frame, 1 is Q in Q's; between them every hinge turns evenly.

        The chain is open at ``open_hinge``. Pieces may collide on the way; a `riot.transform.motion.Motion` is a way
        on which they do not. Ours.

        >>> [len(transform.parts(transform.pose(t))) for t in (0.0, 0.5, 1.0)]
        [4, 4, 4]
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

    def parts(self, pose: Pose) -> list[FloatArray]:
        """The n pieces' polygons in a pose, counter-clockwise, each point once.

        >>> pieces = transform.parts(transform.pose(0.0))  # closed as P
        >>> pieces[0].shape[1]
        2
        """
        return [pose.place(i, piece.polygon) for i, piece in enumerate(self.pieces)]

    def outline_p(self) -> FloatArray:
        """(m, 2) outline of the assembled P, counter-clockwise, in P's frame.

        >>> from shapely import Polygon
        >>> Polygon(transform.outline_p()).is_simple
        True
        """
        pose = self.pose(0.0)
        return np.concatenate([pose.place(i, piece.lower[:-1]) for i, piece in enumerate(self.pieces)])

    def outline_q(self) -> FloatArray:
        """(m, 2) outline of the assembled Q, counter-clockwise, in Q's frame.

        >>> from shapely import Polygon
        >>> areas = [Polygon(outline).area for outline in (transform.outline_p(), transform.outline_q())]
        >>> bool(abs(areas[0] - areas[1]) < 1e-9)  # the same pieces
        True
        """
        pose = self.pose(1.0)
        chain = reversed(list(enumerate(self.pieces)))
        return np.concatenate([pose.place(i, piece.upper[:-1]) for i, piece in chain])

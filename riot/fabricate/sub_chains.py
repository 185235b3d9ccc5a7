"""Where the pieces that share a plane are, one in the frame of another, all along the planned motion. Ours."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from riot.fabricate.tuning import GREATEST_TURN
from riot.transform.motion import LIFT, Motion
from riot.types import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class SubChain:
    """Pieces that keep to one plane together, sampled along the motion.

    Parameters
    ----------
    pieces : (m,) int64
        In chain order.
    times : (k,) float64
        Of the samples, as the motion counts them.
    headings : (k, m) float64
        Of the pieces, radians, the first being 0.
    points : (k, m + 1, 2) float64
        Where each piece starts, and the last one ends, in the frame of the first; mm.
    """

    pieces: IntArray
    times: FloatArray
    headings: FloatArray
    points: FloatArray

    def seen_from(self, member: int, points: FloatArray) -> FloatArray:
        """(k, 2) points, one a sample, given in the first piece's frame, in that of a member's; mm."""
        local = points - self.points[:, member]
        c, s = np.cos(self.headings[:, member]), np.sin(self.headings[:, member])
        return np.stack([c * local[:, 0] + s * local[:, 1], c * local[:, 1] - s * local[:, 0]], axis=1)

    def place(self, member: int, sample: int, points: FloatArray) -> FloatArray:
        """(k, 2) points of a member's frame in the first piece's frame at one sample; mm."""
        heading = float(self.headings[sample, member])
        c, s = math.cos(heading), math.sin(heading)
        placed: FloatArray = points @ np.array([[c, s], [-s, c]]) + self.points[sample, member]
        return placed


def sub_chains(motion: Motion, scale: float) -> list[SubChain]:
    """The parts of the chain between the open hinge and the lifting ones, lowest plane first.

    Samples are so close that no piece turns by more than `GREATEST_TURN` against another between two of them.
    """
    n = len(motion.chain.lengths)
    cuts = (motion.open_hinge, *motion.lifted)
    chains = []
    for cut, following in zip(cuts, (*cuts[1:], cuts[0]), strict=True):
        pieces = (cut + np.arange((following - cut - 1) % n + 1)) % n
        chains.append(sub_chain_at(motion, scale, pieces, _times(motion, pieces[1:])))
    return chains


def sub_chain_at(motion: Motion, scale: float, pieces: IntArray, times: FloatArray) -> SubChain:
    """These pieces, in chain order, at these times (k,) of the motion."""
    hinges = pieces[1:].tolist()
    turns = np.array([np.interp(times, motion.times, motion.turns[:, hinge]) for hinge in hinges]).T
    headings = np.concatenate([np.zeros((len(times), 1)), np.cumsum(turns.reshape(len(times), -1), axis=1)], axis=1)
    lengths = scale * motion.chain.lengths[pieces]
    edges = lengths[None, :, None] * np.stack([np.cos(headings), np.sin(headings)], axis=2)
    points = np.concatenate([np.zeros((len(times), 1, 2)), np.cumsum(edges, axis=1)], axis=1)
    return SubChain(pieces, times, headings, points)


def moving(motion: Motion) -> FloatArray:
    """Times of the key frames between which hinges turn: all, or those between lifting and lowering."""
    first, last = (0.0, 1.0) if motion.flat else (LIFT, 1.0 - LIFT)
    return motion.times[(motion.times >= first) & (motion.times <= last)]


def _times(motion: Motion, hinges: IntArray) -> FloatArray:
    stops = moving(motion)
    turns = motion.turns[np.isin(motion.times, stops)][:, hinges]
    times = [stops[:1]]
    for k in range(len(stops) - 1):
        count = max(1, math.ceil(float(np.abs(turns[k + 1] - turns[k]).sum()) / GREATEST_TURN))
        times.append(stops[k] + np.arange(1, count + 1) / count * (stops[k + 1] - stops[k]))
    return np.concatenate(times)

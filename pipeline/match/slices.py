"""Search a mined collection for counterparts of a solid's slices."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from pipeline.match.search import MinedRun, trunks_as_mined
from pipeline.match.shapes import read_shapes
from riot.geometry.shape import Shape
from riot.scores.index import best_partners
from riot.scores.trunk_stack import stack
from riot.slices.assign import Candidate, Shortlist


def shortlists(
    mined: MinedRun, slices: Sequence[Shape], keep: int, note: Callable[[str], None]
) -> tuple[Shortlist, ...]:
    """The ``keep`` best counterparts of every slice by QCRS among a run's shapes, exact, through its index.

    ``note`` hears when the index has to be built.

    Raises `StartError` if the run's store is gone or altered.
    """
    index = mined.index(note)
    queries = stack([trunks_as_mined(mined, shape) for shape in slices])
    scores = best_partners(index, queries, keep, mined.config.qcrs.sigmas).scores
    numbers = mined.numbers[scores.j].tolist()
    shapes = read_shapes(mined, set(numbers))
    candidates: list[list[Candidate]] = [[] for _ in slices]
    for i, number, score in zip(scores.i.tolist(), numbers, scores.score.tolist(), strict=True):
        candidates[i].append(Candidate(shapes[number], score))
    return tuple(tuple(shortlist) for shortlist in candidates)

"""Searches of which older ones have something: the same shapes were searched for in shards that have changed (ours).

Of a shape's partners in a shard an older search has the best, and the score that all others are below. If the shard
has the same shapes and some more, the best of the older partners and of the added shapes are the best of all. If some
are gone, that holds where those left and those added leave no room for what the older search did not keep. Only other
shapes are searched for anew: the rows that come out are the same to the bit.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.errors import PayloadError
from pipeline.plan.sub_block import SubBlock
from pipeline.stages.partner_rows import TYPES, Rows, best_rows, counting, join, last_of_best, not_below
from pipeline.stages.qcrs import COLUMNS
from pipeline.store.artifact import AnyArray, Artifact
from riot import scores
from riot.types import FloatArray, IntArray

if TYPE_CHECKING:
    from pipeline.stages.search_spec import Search, Wanted
    from riot.parameters import QcrsParameters
    from riot.scores.trunk_stack import TrunkStack

Find = Callable[[Sequence["TrunkStack"], IntArray], Artifact]
"""From the stacks of a query and the numbers of some of its shapes to their rows, as in a run over all pairs."""


@dataclass(frozen=True, eq=False)
class OlderSearch:
    """The number of the input that is an older search, and what the numbers in it mean.

    ``shapes`` (query there,) are the numbers here of its query's shapes, −1 for those not to be taken from it. ``j``
    are the numbers here of the shapes of its shards, −1 for those that are gone.
    """

    source: int
    shapes: IntArray
    j: IntArray


@dataclass(frozen=True)
class AddedShape:
    """A shape of the shards that no older search knows: the number of the input that is its batch, its number there,
    its number in the shards, and whether the query comes after its shard."""

    source: int
    index: int
    j: int
    after: bool


@dataclass(frozen=True, eq=False)
class ReusedGroup:
    """``shapes`` of a query that the same ``older`` searches know, and what has been ``added`` since, batch by batch.

    If no older search knows them, all shapes of the shards are added.
    """

    shapes: tuple[int, ...]
    older: tuple[OlderSearch, ...]
    added: tuple[AddedShape, ...]


@dataclass(frozen=True, eq=False)
class ReusingSearch:
    """A search of which older ones have something. They are no part of its key, as they change no result.

    ``inputs`` are as many as it has without them, ``lengths`` are the numbers of shapes of the query's batches.
    """

    search: Search
    inputs: int
    lengths: tuple[int, ...]
    groups: tuple[ReusedGroup, ...]


def whole_search(spec: Search | SubBlock | ReusingSearch) -> Search:
    """The search that a spec has, or is a part of."""
    if isinstance(spec, SubBlock):
        whole: Search = spec.whole
        return whole
    return spec.search if isinstance(spec, ReusingSearch) else spec


def search_exactly(
    inputs: Sequence[Any], spec: Search | SubBlock | ReusingSearch, wanted: Wanted, known: Rows, find: Find
) -> Artifact:
    """The rows of all shapes of a query that count beside the ``known`` ones; what older searches lack is found."""
    if isinstance(spec, ReusingSearch):
        reused, left = reuse(inputs, spec, wanted, known)
        if len(left) == 0:
            return reused  # neither shards nor, unless shapes were added, trunks are read
        stacks = list(inputs[: spec.search.batches])
        anew = counting(find(stacks, left), left, known, sum(spec.lengths), wanted.count)
        return join([reused, anew])
    stacks = list(inputs[: whole_search(spec).batches])
    shapes = sum(map(len, stacks))
    rows = np.arange(*spec.rows) if isinstance(spec, SubBlock) else np.arange(shapes)
    return counting(find(stacks, rows), rows, known, shapes, wanted.count)


def reuse(inputs: Sequence[Any], spec: ReusingSearch, wanted: Wanted, known: Rows) -> tuple[Artifact, IntArray]:
    """The rows of those shapes of a query of which older searches have enough, and the numbers of the other shapes."""
    found = [join([])]
    left = np.ones(sum(spec.lengths), dtype=bool)
    for group in spec.groups:
        artifact = _of_group(inputs, spec, group, wanted, known)
        found.append(artifact)
        left[artifact.arrays["searched"]] = False
    return join(found), np.flatnonzero(left)


def _of_group(inputs: Sequence[Any], spec: ReusingSearch, group: ReusedGroup, wanted: Wanted, known: Rows) -> Artifact:
    """`reuse` of a group; nothing if an older search cannot be read any more."""
    shapes, count = sum(spec.lengths), wanted.count
    older = []
    for piece in group.older:
        try:
            older.append(_read(piece, inputs[piece.source].arrays, shapes, count))
        except (KeyError, OSError, PayloadError):
            return join([])
    enough = np.isin(np.arange(shapes), group.shapes)
    for piece_there in older:
        enough &= piece_there.searched
    empty = {name: np.empty(0, TYPES.get(name, np.int32)) for name in COLUMNS}
    columns = {name: np.concatenate([empty[name], *(there.rows[name] for there in older)]) for name in COLUMNS}
    _, first = np.unique(np.column_stack([columns["i"], columns["j"]]), axis=0, return_index=True)
    columns = {name: column[first][enough[columns["i"][first]]] for name, column in columns.items()}

    asked = np.flatnonzero(enough)
    added = _added(inputs, spec, group, asked, [known, columns], wanted)
    best = best_rows({name: np.concatenate([columns[name], added[name]]) for name in COLUMNS}, count)
    least = last_of_best([known, best], shapes, count)
    for known_there in older:
        is_above = (least > known_there.above) | (known_there.is_below & (least == known_there.above))
        enough &= is_above | known_there.is_full
    rows = Artifact(not_below(best, np.where(enough, 0.0, np.inf)))
    return counting(rows, np.flatnonzero(enough), known, shapes, count)


@dataclass(frozen=True, eq=False)
class _Older:
    """What an older search has of the shapes of a query, all numbered as here.

    ``rows`` are those that are left. Of each shape: whether it was ``searched``; what no partner without a row scores
    ``above``; whether they all score less (``is_below``); and whether it has as many partners as are wanted, none of
    which is gone (``is_full``).
    """

    rows: Rows
    searched: AnyArray
    above: FloatArray
    is_below: AnyArray
    is_full: AnyArray


def _read(piece: OlderSearch, arrays: Mapping[str, AnyArray], shapes: int, count: int) -> _Older:
    i = piece.shapes[arrays["i"]]
    here = i >= 0
    i, score = i[here], np.asarray(arrays["score"][here])
    j = piece.j[arrays["j"][here]]
    wanted = np.bincount(i, minlength=shapes) >= count
    last = np.full(shapes, np.inf)
    np.minimum.at(last, i, score)
    number = piece.shapes[arrays["searched"]]
    searched, least = np.zeros(shapes, dtype=bool), np.zeros(shapes)
    searched[number[number >= 0]] = True
    least[number[number >= 0]] = arrays["least"][number >= 0]
    is_full = wanted & (np.bincount(i[j < 0], minlength=shapes) == 0)
    rows = {**{name: arrays[name][here][j >= 0] for name in COLUMNS}, "i": i[j >= 0], "j": j[j >= 0]}
    return _Older(rows, searched, np.where(wanted, last, least), ~wanted, is_full)


def _added(
    inputs: Sequence[Any],
    spec: ReusingSearch,
    group: ReusedGroup,
    asked: IntArray,
    known: Sequence[Rows],
    wanted: Wanted,
) -> Rows:
    """Rows of the shapes ``asked`` with all added ones, but those that cannot count beside the ``known`` ones."""
    found: list[Rows] = [{name: np.empty(0, TYPES.get(name, np.int32)) for name in COLUMNS}]
    starts = np.cumsum([0, *spec.lengths]).tolist()
    for batch, (start, stop) in enumerate(pairwise(starts)):
        i = asked[(start <= asked) & (asked < stop)]
        if not (group.added and len(i)):
            continue
        query = _some(inputs[batch], i - start)
        near: list[Rows] = [{name: rows[name][np.isin(rows["i"], i)] for name in ("i", "score")} for rows in known]
        for source, shapes in groupby(group.added, key=lambda shape: shape.source):
            added = list(shapes)
            others = _some(inputs[source], np.array([shape.index for shape in added]))
            # What is found in a batch narrows the search of the next.
            least = last_of_best(near, stop, wanted.count)
            rows = _score(query, i, others, added, spec.search.shards[0].first, wanted.settings, least)
            found.append(rows)
            near.append(rows)
    return {name: np.concatenate([rows[name] for rows in found]) for name in COLUMNS}


def _some(stack: TrunkStack, numbers: IntArray) -> TrunkStack:
    """Some shapes of a stack: itself if these are all."""
    return stack if len(numbers) == len(stack) else scores.index.join([stack.shape(number) for number in numbers])


def _score(
    query: TrunkStack,
    i: IntArray,
    others: TrunkStack,
    added: Sequence[AddedShape],
    first: int,
    settings: QcrsParameters,
    least: FloatArray,
) -> Rows:
    """Rows of all pairs of the shapes ``i``, a stack, and added ones, another, that score no less than ``least``."""
    j, after = np.array([shape.j for shape in added]), np.array([shape.after for shape in added])
    k, m = (grid.ravel() for grid in np.meshgrid(np.arange(len(i)), np.arange(len(j))))
    own = first + i[k] if first >= 0 else np.full(len(k), -1)
    is_earlier = j[m] < own if first >= 0 else after[m]
    pieces: list[Rows] = []
    for added_first in (False, True):
        here = (is_earlier == added_first) & (j[m] != own)
        pairs, limits = np.column_stack([k[here], m[here]]), least[i[k[here]]]
        # A pair is scored from the side of its earlier shape, as in a run over all pairs.
        if added_first:
            block = scores.qcrs.score_pairs(others, query, pairs[:, ::-1], settings, limits)
        else:
            block = scores.qcrs.score_pairs(query, others, pairs, settings, limits)
        rows = {name: np.asarray(getattr(block, name)) for name in COLUMNS}
        pieces.append(not_below({**rows, "i": i[k[here]], "j": j[m[here]]}, least))
    return {name: np.concatenate([rows[name] for rows in pieces]) for name in COLUMNS}

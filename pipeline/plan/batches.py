"""Batches: work items of a few dozen shapes, cut by content so that a growing collection keeps most of them.

The items stand in canonical order (by name). A batch ends after an item whose digest falls in a fixed residue class,
once it has its least size, and at the latest at its greatest: a new item changes its own batch and seldom the next.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence

LEAST_GROUPS = 32
"""Groups of a collection before they grow: some 500 blocks of pairs, enough for a hundred workers (ours)."""

SHAPES_IN_A_GROUP = 512
"""Shapes of a group at most: a block of pairs between two takes about half a minute, at .15 ms a pair (ours)."""


GROUPS_JOINED = (3, 4)
"""Mean numbers by which neighbouring groups are joined: first to those of a rare block, which costs a tenth, then again
and again to those of the selection's tree. As small ones are cut, they come out as some 1.9 and 3 (ours)."""

ROOT = 5
"""Most spans of groups whose pairs the selection reads at once: 15 parts (ours)."""

SPREAD = (0.5, 1.5)
"""Least and greatest size of a group by its mean: the greatest block is to be done in a worker's time limit (ours)."""


def cut(digests: Sequence[str], mean: int, spread: tuple[float, float] = (0.25, 2.0)) -> list[range]:
    """Ranges of positions that cover ``digests`` in order, of about ``mean`` items each.

    The least and the greatest size are ``spread`` times the mean; a narrower spread lowers the mean itself somewhat.
    """
    if mean < 1:
        raise ValueError(f"mean batch size {mean}: give 1 or more")
    least, greatest = max(1, int(spread[0] * mean)), int(spread[1] * mean)
    modulus = max(1, mean - least)
    batches: list[range] = []
    start = 0
    for position, digest in enumerate(digests):
        size = position + 1 - start
        if size >= greatest or (size >= least and _residue(digest, modulus) == 0):
            batches.append(range(start, position + 1))
            start = position + 1
    if start < len(digests):
        batches.append(range(start, len(digests)))
    return batches


def batches_in_a_group(batches: int, shapes: int) -> int:
    """So many batches, of about ``shapes`` each, make a group: one in a small collection, and twice as many whenever
    that has grown to twice the size, up to `SHAPES_IN_A_GROUP`.

    >>> [batches_in_a_group(count, 32) for count in (1, 44, 100, 625, 3125)]
    [1, 2, 4, 16, 16]
    """
    count = 1
    while batches > LEAST_GROUPS * count and 2 * count * shapes <= SHAPES_IN_A_GROUP:
        count *= 2
    return count


def spans_of_groups(contents: Sequence[str]) -> list[list[range]]:
    """Spans of the groups that have these ``contents``, level by level, each of neighbouring spans of the level before.

    The first level is that of rare blocks. A higher one follows while the last has more than `ROOT`. They are cut by
    content: a new shape changes, on each level, the span that it is in, and seldom the next.

    >>> [len(level) for level in spans_of_groups([str(number) for number in range(60)])]
    [31, 9, 3]
    """
    levels: list[list[range]] = []
    spans = [range(number, number + 1) for number in range(len(contents))]
    digests = list(contents)
    while not levels or len(spans) > ROOT:
        joined = cut(digests, GROUPS_JOINED[min(len(levels), 1)], SPREAD)
        digests = [_digest("".join(digests[part.start : part.stop])) for part in joined]
        spans = [range(spans[part.start].start, spans[part.stop - 1].stop) for part in joined]
        levels.append(spans)
    return levels


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def _residue(digest: str, modulus: int) -> int:
    # Hashed again, so that any kind of digest is spread evenly.
    return int.from_bytes(hashlib.sha256(digest.encode()).digest()[:8], "little") % modulus

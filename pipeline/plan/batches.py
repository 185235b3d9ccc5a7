"""Batches: work items of a few dozen shapes, cut by content so that a growing collection keeps most of them.

The items stand in canonical order (by name). A batch ends after an item whose digest falls in a fixed residue class,
once it has its least size, and at the latest at its greatest: a new item changes its own batch and seldom the next.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence


def cut(digests: Sequence[str], mean: int) -> list[range]:
    """Ranges of positions that cover ``digests`` in order, of about ``mean`` items each, from mean/4 to 2·mean."""
    if mean < 1:
        raise ValueError(f"mean batch size {mean}: give 1 or more")
    least, greatest = max(1, mean // 4), 2 * mean
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


def _residue(digest: str, modulus: int) -> int:
    # Hashed again, so that any kind of digest is spread evenly.
    return int.from_bytes(hashlib.sha256(digest.encode()).digest()[:8], "little") % modulus

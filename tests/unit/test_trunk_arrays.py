"""Trunks in artifacts: what was packed comes back, shape by shape and as a stack."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pipeline.stages.qcrs import stack_of_batch
from pipeline.stages.trunk_arrays import pack_trunks, unpack_trunks
from pipeline.store.artifact import AnyArray, Artifact, decode, encode
from riot.scores.leaves import gather_leaves
from riot.scores.trunk_stack import stack
from riot.scores.trunks import Trunks


def some_trunks(seed: int, count: int) -> Trunks:
    rng = np.random.default_rng(seed)
    sizes = rng.integers(3, 6, count)
    offsets = np.concatenate([np.zeros(1, np.int64), np.cumsum(sizes)]).astype(np.int64)
    corners = int(offsets[-1])
    vertices = rng.integers(0, 99, corners).astype(np.int32)
    edges, alphas, thetas = rng.random((3, corners))
    return Trunks(offsets, vertices, edges, alphas, thetas, rng.random(count))


def test_trunks_come_back_one_by_one_and_as_a_stack_of_all() -> None:
    packed = [None, some_trunks(1, 3), some_trunks(2, 0), some_trunks(3, 5), None]
    one_by_one = [trunks or some_trunks(0, 0) for trunks in packed]
    leaves = [gather_leaves(trunks) for trunks in one_by_one]
    of_leaves = {"leaves": np.concatenate(leaves), "leaf_offsets": np.cumsum([0, *map(len, leaves)])}
    batch = decode(encode(Artifact({**pack_trunks(packed), **of_leaves})))
    for index, trunks in enumerate(one_by_one):
        unpacked = unpack_trunks(batch, index)
        same(trunks.to_arrays(), unpacked.to_arrays())
    same(stack(one_by_one, leaves).to_arrays(), stack_of_batch(batch).to_arrays())


def same(expected: Mapping[str, AnyArray], found: Mapping[str, AnyArray]) -> None:
    for name, array in found.items():
        assert np.array_equal(array, expected[name]) and array.dtype == expected[name].dtype, name
        assert array.flags.writeable and array.flags.c_contiguous, name  # else kernels would compile anew

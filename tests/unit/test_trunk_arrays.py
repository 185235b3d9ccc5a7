"""Trunks in artifacts: what was packed comes back, shape by shape and all at once."""

from __future__ import annotations

import numpy as np

from pipeline.stages.trunk_arrays import pack_trunks, unpack_batch_trunks, unpack_trunks
from pipeline.store.artifact import Artifact, decode, encode
from riot.scores.trunks import Trunks


def some_trunks(seed: int, count: int) -> Trunks:
    rng = np.random.default_rng(seed)
    sizes = rng.integers(3, 6, count)
    offsets = np.concatenate([np.zeros(1, np.int64), np.cumsum(sizes)]).astype(np.int64)
    corners = int(offsets[-1])
    vertices = rng.integers(0, 99, corners).astype(np.int32)
    edges, alphas, thetas = rng.random((3, corners))
    return Trunks(offsets, vertices, edges, alphas, thetas, rng.random(count))


def test_trunks_come_back_one_by_one_and_all_at_once() -> None:
    packed = [None, some_trunks(1, 3), some_trunks(2, 0), some_trunks(3, 5), None]
    batch = decode(encode(Artifact(pack_trunks(packed))))
    together = unpack_batch_trunks(batch)
    assert len(together) == len(packed)
    for index, trunks in enumerate(packed):
        expected = (trunks or some_trunks(0, 0)).to_arrays()
        for unpacked in (unpack_trunks(batch, index), together[index]):
            for name, array in unpacked.to_arrays().items():
                assert np.array_equal(array, expected[name]) and array.dtype == expected[name].dtype
                assert array.flags.writeable and array.flags.c_contiguous  # else kernels would compile anew
    assert unpack_batch_trunks(decode(encode(Artifact(pack_trunks([]))))) == []

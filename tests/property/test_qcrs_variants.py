"""The variants of QCRS: which trunks and sigmas each compares, and what follows for it beside CRS."""

from __future__ import annotations

import numpy as np
import pytest
from blobs import blob
from scipy.stats import kendalltau

from riot.parameters import QCRS_VARIANTS, QcrsParameters
from riot.scores.crs import crs
from riot.scores.qcrs import brute_force, qcrs, score_block
from riot.scores.reversibility import Reversibility
from riot.scores.trunk_stack import stack
from riot.scores.trunks import Trunks, compared_trunks, full_trunks, quick_trunks

SHAPES = [blob(seed, waves=6) for seed in range(8)]


def alike(trunks: Trunks, other: Trunks) -> bool:
    """Whether two lists of trunks are the same bits."""
    mine, others = trunks.to_arrays(), other.to_arrays()
    return all(np.array_equal(mine[name], others[name]) for name in mine)


def test_each_variant_compares_its_trunks() -> None:
    for shape in SHAPES[:3]:
        assert alike(compared_trunks(shape, "paper"), quick_trunks(shape))
        assert alike(compared_trunks(shape, "tuned"), full_trunks(shape))
    assert QCRS_VARIANTS["paper"] == QcrsParameters()


def test_necks_are_found_for_the_paper_variant_alone() -> None:
    def never() -> Reversibility:
        raise AssertionError("asked for")

    compared_trunks(SHAPES[0], "tuned", None, never)
    with pytest.raises(AssertionError, match="asked for"):
        compared_trunks(SHAPES[0], "paper", None, never)


def test_the_search_is_exact_with_the_tuned_trunks_and_sigmas() -> None:
    everything = stack([full_trunks(shape) for shape in SHAPES[:5]])
    sigmas = QCRS_VARIANTS["tuned"]
    quick, brute = (way(everything, everything, sigmas, same=True) for way in (score_block, brute_force))
    assert (brute.n > 0).any()
    for name in vars(brute):
        assert np.array_equal(getattr(quick, name), getattr(brute, name)), name


def test_one_pair_scores_by_its_variant() -> None:
    a, b = SHAPES[:2]
    for variant, sigmas in QCRS_VARIANTS.items():
        both = stack([compared_trunks(a, variant)]), stack([compared_trunks(b, variant)])
        assert qcrs(a, b, variant=variant).score == score_block(*both, sigmas).score[0]


def test_the_tuned_variant_bounds_edges_and_angles_as_crs_has_them() -> None:
    # With no weight on areas, QCRS is CRS without its area term: no pair of trunks can score more.
    everything = stack([full_trunks(shape) for shape in SHAPES])
    scores = score_block(everything, everything, QcrsParameters(sigma_area=1e9), same=True)
    cross = np.array([crs(SHAPES[i], SHAPES[j]).score for i, j in zip(scores.i, scores.j, strict=True)])
    assert (cross > 0).any()
    assert (scores.score >= cross - 1e-12).all()


def test_the_tuned_variant_orders_pairs_more_as_crs_does() -> None:
    i, j = np.triu_indices(len(SHAPES), 1)
    cross = [crs(SHAPES[a], SHAPES[b]).score for a, b in zip(i, j, strict=True)]
    agreement = {}
    for variant, sigmas in QCRS_VARIANTS.items():
        everything = stack([compared_trunks(shape, variant) for shape in SHAPES])
        agreement[variant] = kendalltau(score_block(everything, everything, sigmas, same=True).score, cross)[0]
    assert agreement["tuned"] > agreement["paper"]

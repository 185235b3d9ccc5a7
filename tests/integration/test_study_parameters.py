"""The study of parameters: what its measures are, that looser filters lose nothing, and what it writes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from given_run import given_run
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.study.findings import svg, write_findings
from pipeline.study.hidden import NEAR, Hidden, failed_test, hide, nearest
from pipeline.study.ordering import orders, reordered
from pipeline.study.parameters import TIMES, Parameters, study
from pipeline.study.varied import vary
from riot import Shape
from riot.errors import ParameterError
from riot.parameters import ReversibilityParameters, TrunkParameters
from riot.scores.reversibility import reversibility
from riot.scores.trunks import Trunks, full_trunks
from riot.units import L_C

DEFAULT = TrunkParameters()
LOOSER = {"min_area": 0.005, "min_inside": 0.8, "max_arc": 0.6, "max_overlap": 0.2}
QUICK = Parameters((12.0,), (), (0.05,), (2.0,), (8.0,), pairs=2, shapes=3)
FACTORS = st.floats(0.2, 5.0)
TERMS = st.lists(st.tuples(st.floats(0.01, 1.0), st.floats(0.01, 1.0)), min_size=3, max_size=30)


@pytest.fixture(scope="module")
def hidden() -> list[Hidden]:
    return [side for pair in hide(3, (3, 4))[0] for side in (pair.p, pair.q)]


def rows(trunks: Trunks) -> set[tuple[int, ...]]:
    return {tuple(trunks.of(k).tolist()) for k in range(len(trunks))}


@pytest.mark.parametrize("name", sorted(LOOSER))
def test_a_looser_filter_loses_no_trunk(hidden: Sequence[Hidden], name: str) -> None:
    more = 0
    for hidden_shape in hidden:
        tight = full_trunks(hidden_shape.shape, DEFAULT)
        loose = full_trunks(hidden_shape.shape, replace(DEFAULT, **{name: LOOSER[name]}))  # type: ignore[arg-type]
        assert rows(tight) <= rows(loose)
        assert nearest(hidden_shape, loose) <= nearest(hidden_shape, tight)
        more += len(loose) - len(tight)
    assert more > 0


def test_the_nearest_trunk_is_that_of_brute_force(hidden: Sequence[Hidden]) -> None:
    for hidden_shape in hidden[:4]:
        trunks = full_trunks(hidden_shape.shape, DEFAULT)
        n = len(hidden_shape.corners)
        best = min(
            max(
                float(np.hypot(*(hidden_shape.shape.points[chosen[(j + shift) % n]] - hidden_shape.corners[j])))
                for j in range(n)
            )
            for chosen in rows(trunks)
            if len(chosen) == n
            for shift in range(n)
        )
        assert nearest(hidden_shape, trunks) == pytest.approx(best, rel=1e-12)
        assert nearest(
            replace(hidden_shape, corners=np.roll(hidden_shape.corners, 1, axis=0)), trunks
        ) == pytest.approx(best, rel=1e-12)
        on_trunk = replace(hidden_shape, corners=hidden_shape.shape.points[trunks.of(0)])
        assert nearest(on_trunk, trunks) == 0.0


def test_a_true_trunk_is_found_exactly_if_no_test_loses_it(hidden: Sequence[Hidden]) -> None:
    values = {"spacing": (8.0,), "tau_s": (0.2,), "tau_c": (0.05,)}
    outcomes = list(vary(hidden, [hidden_shape.shape for hidden_shape in hidden[:2]], DEFAULT, values, lambda _: None))
    assert [(outcome.parameter, outcome.value, outcome.default) for outcome in outcomes] == [
        ("spacing", 8.0, False), ("spacing", 15.0, True), ("tau_s", 0.1, True), ("tau_s", 0.2, False),
        ("tau_c", 0.05, False), ("tau_c", 0.3, True),
    ]  # fmt: skip
    for outcome in outcomes:
        assert outcome.found + sum(outcome.lost.values()) == len(hidden)
    assert len({outcome.found for outcome in outcomes}) > 1
    default = next(outcome for outcome in outcomes if outcome.default)
    for which, error in zip(hidden, default.error, strict=True):
        lost = failed_test(which, full_trunks(which.shape, DEFAULT), False, DEFAULT)
        assert (error * L_C <= NEAR) == (lost == "")


@settings(max_examples=25)
@given(FACTORS, FACTORS)
def test_reordered_is_the_score_by_other_sigmas(pa_factor: float, w_factor: float) -> None:
    usual = ReversibilityParameters()
    changed = replace(usual, sigma_pa=usual.sigma_pa * pa_factor, sigma_w=usual.sigma_w * w_factor)
    for points in (((0, 0), (6, 0), (6, 1), (0, 1)), ((0, 0), (4, 0), (2.2, 1), (4, 2), (0, 2), (1.8, 1))):
        shape = Shape.from_polygon(points)
        usual_score = reversibility(shape, usual)
        score = reordered(np.array([usual_score.s1]), np.array([usual_score.s2]), pa_factor, w_factor)
        assert score[0] == pytest.approx(reversibility(shape, changed).score, rel=1e-9, abs=1e-300)


@settings(max_examples=50)
@given(TERMS, FACTORS)
def test_both_sigmas_together_change_no_order(terms: list[tuple[float, float]], factor: float) -> None:
    s1, s2 = np.array(terms).T
    score, reference = reordered(s1, s2, factor, factor), np.minimum(s1, s2)
    order = np.argsort(reference, kind="stable")
    assert (np.diff(score[order]) >= 0.0).all()
    assert (reordered(s1, s2, 1.0, 1.0) == reference).all()


def test_the_own_sigmas_keep_the_order_and_only_their_ratio_counts() -> None:
    s1, s2 = np.random.default_rng(3).random((2, 50))
    s1[7] = np.nan
    usual = {"sigma_pa": 1.0, "sigma_w": 4.0}
    sigma_orders = list(orders(s1, s2, usual, {"sigma_pa": (0.5, 2.0), "sigma_w": (2.0, 8.0)}))
    by_value = {(order.parameter, order.value): order for order in sigma_orders}
    for name, value in usual.items():
        order = by_value[name, value]
        assert order.default and order.kendall == pytest.approx(1.0) and order.kept == 1.0
    assert by_value["sigma_pa", 0.5].kendall == pytest.approx(by_value["sigma_w", 8.0].kendall)
    assert by_value["sigma_pa", 2.0].kendall == pytest.approx(by_value["sigma_w", 2.0].kendall)
    assert by_value["sigma_pa", 0.5].kendall < 1.0


def test_all_but_the_times_is_the_same_again(tmp_path: Path, hidden: Sequence[Hidden]) -> None:
    run = given_run(tmp_path, [hidden_shape.shape for hidden_shape in hidden], 2)
    first, again = (study(run, QUICK, lambda _: None) for _ in range(2))
    assert first.table.equals(again.table, check_metadata=True)
    assert (first.lead, first.sheets) == (again.lead, again.sheets)
    assert svg(first.figures["recovery"][0], "recovery") == svg(again.figures["recovery"][0], "recovery")
    table = first.table.to_pylist()
    write_findings(first, tmp_path / "study")
    times = pq.read_table(tmp_path / "study" / TIMES).to_pylist()
    assert [(row["parameter"], row["value"]) for row in times] == [
        (row["parameter"], row["value"]) for row in table if row["found"] is not None
    ]
    assert all(row["ratio"] > 0.0 for row in times)
    assert [row["ratio"] for row in times if row["value"] == DEFAULT.spacing] == [1.0]
    assert "True trunks lost at" in [sheet.title for sheet in first.sheets] and TIMES in first.lead


def test_values_out_of_range_are_refused() -> None:
    for values, words in (
        ({"tau_c": (1.0,)}, r"tau_c\[0\]: must be greater than 0 and less than 1, got 1.0"),
        ({"spacing": (8.0, 0.0)}, r"spacing\[1\]: must be greater than 0, got 0.0"),
        ({"pairs": 0}, "pairs: must be 1 or more, got 0"),
    ):
        with pytest.raises(ParameterError, match=words):
            Parameters(**values)

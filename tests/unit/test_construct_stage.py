"""The stages that construct: what is stored of an exact transform, of the paper's, and of the paper's beside it."""

from __future__ import annotations

import math
from dataclasses import astuple
from functools import cache

import numpy as np
import pytest

from pipeline.config.build import make_config
from pipeline.errors import ConfigError
from pipeline.report.comparison import read_comparison
from pipeline.stages import construct, paper
from pipeline.stages.crs import pack_scores
from pipeline.stages.refine import run as refine
from pipeline.stages.shape_arrays import pack_shapes
from pipeline.store.artifact import Artifact, decode, encode
from pipeline.tables.messages import sentences
from pipeline.tables.schemas import SCHEMAS
from riot import Shape, Transform
from riot.construction.laplacian import construct_laplacian
from riot.geometry.polyline import signed_area
from riot.groundtruth.pairs import exact_pair, exact_transform
from riot.parameters import ConstructParameters, RefineParameters
from riot.scores.crs import CrossScore
from riot.transform.deformation import change_ratio
from riot.transform.riot_file import from_json, to_json

REACH = RefineParameters().reach
SAMPLE = {"dataset": {"name": "sample", "kind": "sample"}}


def waved(shape: Shape) -> Shape:
    """A little different, so that nothing about it is exact."""
    angle = np.arctan2(shape.points[:, 1], shape.points[:, 0])
    points = shape.points * (1.0 + 0.02 * np.sin(5.0 * angle))[:, None]
    return Shape(points / math.sqrt(signed_area(points)), shape.feature, shape.name, shape.to_source)


@cache
def made(method: str) -> Artifact:
    """What the stages store of one pair that is nearly exact."""
    exact = exact_transform(exact_pair(4, 2))
    p, q = waved(exact.p), waved(exact.q)
    trunks = [
        np.array([np.hypot(*(shape.points - corner).T).argmin() for corner in trunk], dtype=np.int64)
        for shape, trunk in ((p, exact.trunk_p), (q, exact.trunk_q))
    ]
    batch = Artifact(pack_shapes([p, q]))
    cross = Artifact(pack_scores([CrossScore(0.9, trunks[0], trunks[1], 0.9, 0.9, 0.9, 0.1, 1)]), {"errors": []})
    settings = ConstructParameters(method=method)  # type: ignore[arg-type]
    refined = refine(
        [batch, batch, cross],
        [RefineParameters(sketched=0, refined=0), settings.spacing, settings.max_lost_contact],
        (0, 1),
    )
    found = construct.run([batch, batch, cross, refined], [settings, REACH, 5, 0.1], ((0, "P"), (1, "Q")))
    assert "errors" not in found.document
    return decode(encode(found))


def test_an_exact_transform_is_certified_and_measured() -> None:
    document = made("exact").document
    transform, iou = from_json(document["riot"]), min(document["iou_p"], document["iou_q"])
    assert document["status"] == "certified" and transform.certificate().passed
    sides = [change_ratio(document[f"iou_{side}"], document[f"bound_{side}"]) for side in "pq"]
    assert document["change_ratio"] == max(sides) > 0.99 and iou < 1.0
    assert all(0.2 < document[f"bending_{side}"] < 5.0 for side in "pq")
    assert all(0.0 < document[f"direction_{side}"] < 0.5 for side in "pq")


def test_one_by_the_papers_method_is_approximate_and_keeps_text_and_numbers() -> None:
    document = made("laplacian").document
    assert (document["status"], document["reason"]) == ("approximate", "method")
    transform = from_json(document["riot"])
    assert document["message"] == transform.certificate().failure != ""
    numbers = [document[name] for name in (*construct.DEFORMATION, *construct.FIDELITY)]
    residuals = [document[f"{name}_{side}"] for name in construct.RESIDUALS for side in "pq"]
    assert np.isfinite([*numbers, *residuals]).all()
    assert max(map(abs, residuals)) > 1e-6
    assert made("exact").document["riot"] != document["riot"]


def test_columns_are_in_the_table_with_meaning_and_unit() -> None:
    for name in (*construct.FIDELITY, *paper.COLUMNS):
        metadata = SCHEMAS["transforms"].field(name).metadata
        assert metadata[b"meaning"] and metadata[b"unit"]


def test_the_papers_method_is_tried_on_the_same_trunks() -> None:
    document = made("exact").document
    transform = from_json(document["riot"])
    plan = paper.same_trunks(transform, ConstructParameters().snap, REACH)
    assert plan.trunk_p == pytest.approx(transform.pose(0.0).origins, abs=1e-12)
    assert plan.trunk_q == pytest.approx(transform.pose(1.0).origins, abs=1e-12)
    beside = construct_laplacian(plan, ConstructParameters())
    assert beside.chain.lengths == pytest.approx(transform.chain.lengths, abs=1e-9)
    found = paper.run([made("exact")], [ConstructParameters(), REACH], None).document
    assert set(found) == set(paper.COLUMNS)
    assert found["paper_iou"] == beside.deformation().iou
    assert found["paper_gaps"] + found["paper_overlaps"] + found["paper_outside"] > 1e-6


def test_a_transform_that_cannot_be_compared_is_a_row_of_errors(made_wrong: Transform) -> None:
    found = paper.run([Artifact({}, {"riot": to_json(made_wrong)})], [ConstructParameters(), REACH], None)
    assert [row["type"] for row in found.document["errors"]] == ["TrunkError"]


@pytest.fixture
def made_wrong() -> Transform:
    """Its trunk vertices are not in order."""
    transform = exact_transform(exact_pair(4, 2))
    object.__setattr__(transform, "trunk_p", transform.trunk_p[[0, 2, 1, 3]])
    return transform


def row(rank: int, iou: float, paper_iou: float | None) -> dict[str, object]:
    exact = {"iou": iou, "gap_p": -1e-15, "gap_q": 0.0, "overlap_p": 0.0, "overlap_q": 2e-15}
    beside = dict.fromkeys(paper.COLUMNS, None if paper_iou is None else 0.001) | {"paper_iou": paper_iou}
    return {"rank": rank, "name_i": "a", "name_j": "b", "hausdorff_p": 0.01, "hausdorff_q": 0.02} | exact | beside


def test_both_methods_are_compared_where_both_were_tried() -> None:
    timings = [
        {"stage": "construct", "cached": 3, "computed": 1, "stored_seconds": 2.0},
        {"stage": "paper", "cached": 0, "computed": 2, "stored_seconds": 9.0},
    ]
    assert read_comparison([row(1, 0.9, None)], timings) is None
    found = read_comparison([row(1, 0.9, 0.8), row(2, 0.8, 0.4), row(3, 0.7, 0.6), row(4, 0.7, None)], timings)
    assert found is not None and [pair.rank for pair in found.pairs] == [1, 2, 3]
    exact, other = found.medians
    assert (exact.iou, other.iou, exact.hausdorff) == (0.8, 0.6, 0.02)
    assert astuple(other)[1:] == (0.001,) * 4 and exact.residual == pytest.approx(2e-15, abs=2e-15)
    assert (found.seconds_exact, found.seconds_paper) == (0.5, 4.5)
    assert found.unbent is None and "bent" not in found.sentence
    bent = read_comparison([row(1, 0.9, 0.8) | {"unbent_iou": 0.85}], timings)
    assert bent is not None and bent.unbent == 0.85 and "0.900 bent and exact, 0.850 exact" in bent.sentence
    assert (
        "(3 of the best)" in found.sentence and "0.003 of gaps" in found.sentence and "4.5 s a pair" in found.sentence
    )
    assert "s a pair" not in read_comparison([row(1, 0.9, 0.8)], []).sentence  # type: ignore[union-attr]


def test_a_run_says_how_many_are_approximate() -> None:
    assert sentences({"selected": 4, "approximate": 0}, "global") == []
    (said,) = sentences({"selected": 4, "approximate": 1}, "global")
    assert said.startswith("1 transform is approximate")


def test_how_many_are_compared_is_a_parameter() -> None:
    assert make_config(SAMPLE).compare == 0 and make_config({**SAMPLE, "compare": 7}).compare == 7
    with pytest.raises(ConfigError, match="compare: must be 0 or more"):
        make_config({**SAMPLE, "compare": -1})

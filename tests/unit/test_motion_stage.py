"""The stage that plans motions: what it stores, what fails, and what the run says of it."""

from __future__ import annotations

import json

import pytest

from pipeline.config.build import make_config
from pipeline.errors import ConfigError
from pipeline.stages.motion import STAGE, run
from pipeline.store.artifact import Artifact, decode, encode
from pipeline.tables.messages import sentences
from pipeline.tables.schemas import SCHEMAS
from riot.groundtruth.pairs import exact_pair, exact_transform
from riot.motion import MotionParameters, motion_of
from riot.transform.riot_file import from_json, to_json

MADE = to_json(exact_transform(exact_pair(4, 2)))


def test_a_construction_gets_its_plan() -> None:
    found = run([Artifact({}, {"riot": MADE})], [MotionParameters()], None)
    transform = from_json(found.document["riot"])
    assert transform.plan is not None
    assert found.document["swings_flat"] is transform.plan.flat is True
    assert found.document["open_hinge"] == transform.plan.open_hinge
    assert found.document["lifted_hinges"] == []
    assert found.document["motion_search"] == transform.plan.search
    assert "errors" not in found.document
    # Nothing but the plan is new, and the artifact can be stored.
    new = {name: value for name, value in json.loads(found.document["riot"]).items() if name != "motion"}
    assert new == json.loads(MADE)
    assert decode(encode(found)).document == found.document


def test_columns_are_in_the_table() -> None:
    (added,) = STAGE.tables
    assert {column.name for column in added.columns} == {"swings_flat", "lifted_hinges", "open_hinge", "motion_search"}
    for column in added.columns:
        assert SCHEMAS["transforms"].field(column.name).metadata[b"meaning"] == column.meaning.encode()


def test_parameters_reach_the_plan_and_are_checked() -> None:
    settings = make_config({"dataset": {"name": "sample", "kind": "sample"}, "motion": {"gap": 0.005}}).motion
    found = run([Artifact({}, {"riot": MADE})], [settings], None)
    tight = run([Artifact({}, {"riot": MADE})], [MotionParameters()], None)
    gaps = [motion_of(from_json(one.document["riot"])).gap for one in (found, tight)]
    assert gaps[0] == pytest.approx(gaps[1] * 0.005 / MotionParameters().gap)
    for values, words in (
        ({"gap": 0.0}, "motion.gap"),
        ({"relief": 0.7}, "motion.relief"),
        ({"seed": -1}, "motion.seed"),
    ):
        with pytest.raises(ConfigError, match=words):
            make_config({"dataset": {"name": "sample", "kind": "sample"}, "motion": values})


@pytest.mark.parametrize(
    ("planned", "flat", "words"),
    [
        (0, 0, None),
        (4, 4, "4 of 4 transforms (100%) can swing flat."),
        (4, 1, "1 of 4 transforms (25%) can swing flat; the"),
    ],
)
def test_a_run_says_how_many_swing_flat(planned: int, flat: int, words: str | None) -> None:
    said = sentences({"selected": 4, "planned": planned, "swing_flat": flat}, "global")
    assert len(said) == (words is not None)
    assert words is None or said[0].startswith(words)

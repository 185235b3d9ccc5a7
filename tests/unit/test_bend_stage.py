"""The stages that bend: what they store is what the library makes, and a construction without it goes on unbent."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest

from pipeline.config.build import make_config
from pipeline.stages import bend, construct, modes, paper
from pipeline.stages.all import STAGES
from pipeline.stages.crs import pack_scores
from pipeline.stages.refine import bound, unpack_plans
from pipeline.stages.refine import run as refine
from pipeline.stages.shape_arrays import pack_shapes, unpack_shape
from pipeline.stages.trunk_arrays import pack_trunks, unpack_trunks
from pipeline.store.artifact import Artifact, decode, encode
from riot import Shape
from riot.construction.bend import BentPlan, bend_plans
from riot.construction.plan_search import sized_plans
from riot.geometry.modes import modes as elastic_modes
from riot.parameters import BendParameters, ConstructParameters, RefineParameters
from riot.scores.crs import best_trunk_pairs
from riot.scores.trunks import full_trunks
from riot.transform.riot_file import from_json

BEND = BendParameters(method="elastic", steps=8, sketch_steps=4, sketched=2, modes=8)
REFINEMENT, CONSTRUCTION = RefineParameters(), ConstructParameters()
CONTACT = [CONSTRUCTION.spacing, CONSTRUCTION.max_lost_contact]
LIMITS = [*CONTACT, CONSTRUCTION.max_cut_off]
NAMES = ((0, "P"), (1, "Q"))


def stored(artifact: Artifact) -> Artifact:
    return decode(encode(artifact))


@cache
def inputs() -> list[Artifact]:
    """Batch twice, CRS, refined trunks of a house and a blob, then their full trunks."""
    house = Shape.from_polygon([(0, 0), (4, 0), (4, 3), (2, 5), (0, 3)])
    angle = np.linspace(0.0, 2.0 * math.pi, 80, endpoint=False)
    radius = 1.0 + 0.3 * np.cos(3.0 * angle) + 0.1 * np.sin(5.0 * angle)
    blob = Shape.from_polygon(radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)]))
    batch = stored(Artifact(pack_shapes([house, blob])))
    trunks = [full_trunks(shape) for shape in (house, blob)]
    scores = best_trunk_pairs(house, blob, *trunks, count=4)
    cross = stored(Artifact(pack_scores(scores), {"errors": []}))
    refined = stored(refine([batch, batch, cross], [REFINEMENT, *CONTACT], (0, 1)))
    return [batch, batch, cross, refined, *(stored(Artifact(pack_trunks([one]))) for one in trunks)]


def shapes() -> tuple[Shape, Shape]:
    p, q = (unpack_shape(inputs()[0], index) for index in (0, 1))
    assert p is not None and q is not None
    return p, q


@cache
def bent() -> list[Artifact]:
    """The modes of both, and the bent plans."""
    batch, _, *rest = inputs()
    both = [stored(modes.run([batch], [BEND.modes, BEND.straight], index)) for index in (0, 1)]
    of_pair = [batch, batch, *rest[:2], *both, *rest[2:]]
    return [*both, stored(bend.run(of_pair, [BEND, REFINEMENT, *LIMITS], (0, 1)))]


def made_by_library() -> list[BentPlan]:
    p, q = shapes()
    _, _, cross, refined, *trunks = inputs()
    plans, _ = unpack_plans(refined, cross, p, q, REFINEMENT.reach, all_plans=True)
    full = [unpack_trunks(one, 0) for one in trunks]
    starts = sorted([*plans, *sized_plans(p, q, *full, REFINEMENT, BEND.starts)], key=lambda plan: -plan.bound)
    of_p, of_q = (elastic_modes(shape, BEND.modes, BEND.straight) for shape in (p, q))
    return bend_plans(starts, of_p, of_q, BEND, REFINEMENT, CONSTRUCTION)


def test_what_is_stored_is_what_the_library_makes() -> None:
    found = bend.unpack_bent(*bent(), *shapes(), REFINEMENT.reach)
    expected = made_by_library()
    assert len(found) == len(expected) > 0
    for one, other in zip(found, expected, strict=True):
        assert one.worth == other.worth and one.plan.bound == other.plan.bound
        assert np.array_equal(one.plan.trunks, other.plan.trunks)
        for side in ("p", "q"):
            a, b = getattr(one, side), getattr(other, side)
            assert np.allclose(a.bent.points, b.bent.points, rtol=0.0, atol=1e-14)
            assert a.rms_strain == pytest.approx(b.rms_strain, rel=1e-9)


def constructed(*bending: Artifact) -> Artifact:
    return construct.run([*inputs()[:4], *bending], [CONSTRUCTION, REFINEMENT.reach, BEND.judged, BEND.limbs], NAMES)


def test_a_construction_takes_the_bent_plans_and_tells_what_they_cost() -> None:
    plain, document = constructed().document, constructed(*bent()).document
    assert plain["status"] == document["status"] == "certified"
    made = from_json(document["riot"])
    assert made.bend_p is not None and made.bend_q is not None and (made.p.name, made.q.name) == ("P", "Q")
    assert max(document["rms_strain_p"], document["rms_strain_q"]) > 0.0
    assert min(document["iou_p"], document["iou_q"]) > min(plain["iou_p"], plain["iou_q"])
    assert document["input_iou_p"] < document["iou_p"]
    assert plain["rms_strain_p"] == 0.0 and plain["input_iou_p"] == plain["iou_p"]


def test_without_modes_or_bent_plans_the_shapes_are_cut_as_they_are() -> None:
    none = stored(Artifact({}, {"errors": []}))
    batch, _, *rest = inputs()
    found = bend.run([batch, batch, *rest[:2], none, bent()[1], *rest[2:]], [BEND, REFINEMENT, *LIMITS], (0, 1))
    assert bend.unpack_bent(none, bent()[1], stored(found), *shapes(), REFINEMENT.reach) == []
    assert constructed(none, bent()[1], stored(found)).document == constructed().document


def test_the_bound_is_that_of_plans_that_keep_contact_and_have_so_many_pieces() -> None:
    arrays = {"bounds": np.array([[0.99, 0.98], [0.9, 0.95], [0.8, 0.7]]), "offsets": np.array([0, 5, 9, 14])}
    artifact = Artifact(arrays, {"first": 1})
    assert (bound(artifact), bound(artifact, [5]), bound(artifact, [3])) == (0.9, 0.7, 0.0)


def test_the_paper_stands_beside_the_transform_without_a_bend() -> None:
    made = constructed(*bent())
    found = paper.run([made, *inputs()[:4]], [CONSTRUCTION, REFINEMENT.reach], NAMES).document
    plain = constructed().document
    assert found["unbent_iou"] == min(plain["iou_p"], plain["iou_q"])
    assert 0.0 < found["paper_iou"] < 1.0
    hopeless = ConstructParameters(max_lost_contact=0.0, max_cut_off=0.0)
    none = paper.run([made, *inputs()[:4]], [hopeless, REFINEMENT.reach], NAMES).document
    assert none == {"errors": []}


def test_a_run_bends_only_if_it_is_asked_to() -> None:
    sample = {"dataset": {"name": "sample", "kind": "sample"}}
    for method in ("off", "elastic"):
        config = make_config({**sample, "bend": {"method": method}})
        wanted = {stage.name for stage in STAGES if stage.wanted(config)}
        assert ({"modes", "bend"} <= wanted) == (method == "elastic")

"""Construction and certificate of one pair (paper §4.3; the exact partition is ours)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.plan.progress import Progress
from pipeline.plan.work_item import WorkItem
from pipeline.stages.bend import unpack_bent
from pipeline.stages.refine import unpack_plans
from pipeline.stages.shape_arrays import ErrorRow, attempt, expect_shape
from pipeline.stages.shortlist import shortlisted
from pipeline.stages.stage import Column, Stage, TableColumns
from pipeline.store.artifact import Artifact
from riot import construction, geometry, transform
from riot.errors import ConstructionError, TrunkError
from riot.parameters import BendParameters

if TYPE_CHECKING:
    from riot.transform.deformation import Deformation
    from riot.transform.transform import Transform

Spec = tuple[tuple[int, str], tuple[int, str]]
"""Local index and name of P and of Q; the names are in the file that is written."""


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: Spec) -> Artifact:
    """Batches of P and Q, the pair's CRS and refined trunks → a document: status, reason, ``.riot`` text, numbers.

    Both shapes' modes and the pair's bent plans may follow: these are tried first. A transform by the paper's method
    is ``approximate``: its certificate fails, but it has a text and numbers.
    """
    batch_p, batch_q, cross, refined, *bending = inputs
    settings, reach, judged, limbs = parameters
    bend = BendParameters(judged=judged, limbs=limbs)
    (index_p, name_p), (index_q, name_q) = spec
    p, q = expect_shape(batch_p, index_p, name_p), expect_shape(batch_q, index_q, name_q)
    plans, unplanned = unpack_plans(refined, cross, p, q, reach)
    if not plans and not unplanned:
        return _rejected("no-trunks", "no pair of full trunks has the same number of vertices")
    errors: list[ErrorRow] = []

    def construct() -> Artifact:
        try:
            if bending:
                modes_p, modes_q, bent = bending
                best = unpack_bent(modes_p, modes_q, bent, p, q, reach)
                made = construction.bent_choice.construct_bent(best, plans, unplanned, bend, settings)
            else:
                made = construction.plan_transform.construct_plans(plans, unplanned, settings)
            return _measured(made, settings.method)
        except ConstructionError as error:
            return _rejected(error.reason, str(error))
        except TrunkError as error:
            return _rejected("trunks", str(error))

    result = attempt(0, construct, errors)
    return result if result is not None else Artifact({}, {"status": "failed", "errors": errors})


def _measured(result: Transform, method: str) -> Artifact:
    certificate, deformation = transform.certificate.certify(result), transform.deformation.measure_deformation(result)
    sides = {"p": certificate.p, "q": certificate.q}
    numbers = {
        "n": len(result),
        **{name: float(getattr(deformation, name)) for name in DEFORMATION},
        "bound_p": float(result.bound_p),
        "bound_q": float(result.bound_q),
        **_fidelity(result, deformation),
        **{
            f"{term}_{side}": float(getattr(certified_side, term))
            for side, certified_side in sides.items()
            for term in RESIDUALS
        },
    }
    if certificate.passed:
        status = {"status": "certified", "reason": "", "message": ""}
    elif method == "laplacian":  # its pieces overlap and leave gaps by nature
        status = {"status": "approximate", "reason": "method", "message": certificate.failure}
    else:
        return Artifact({}, {**_rejected("certificate", certificate.failure).document, **numbers})
    # The outlines are in the file, too; whoever needs them alone need not read it.
    outlines = {"outline_p": result.outline_p(), "outline_q": result.outline_q()}
    return Artifact(outlines, {**status, "riot": transform.riot_file.to_json(result), **numbers})


def _fidelity(result: Transform, deformation: Deformation) -> dict[str, float | None]:
    """Compute the numbers `FIDELITY`; takes 20 ms a pair (measured on MPEG-7)."""
    changes = (
        transform.deformation.change_ratio(deformation.iou_p, result.bound_p),
        transform.deformation.change_ratio(deformation.iou_q, result.bound_q),
    )
    p, q = (result.outline_p(), result.p.points), (result.outline_q(), result.q.points)
    fidelity = transform.fidelity
    lines_p, lines_q = (transform.centreline.centre_line_overlap(*both) for both in (p, q))
    return {
        "change_ratio": max((change for change in changes if not math.isnan(change)), default=None),
        "bending_p": fidelity.bending_ratio(*p),
        "bending_q": fidelity.bending_ratio(*q),
        "direction_p": fidelity.direction_error(*p),
        "direction_q": fidelity.direction_error(*q),
        "cldice": min(lines_p.dice, lines_q.dice),
        "centreline_precision_p": lines_p.precision,
        "centreline_precision_q": lines_q.precision,
        "centreline_recall_p": lines_p.recall,
        "centreline_recall_q": lines_q.recall,
    }


DEFORMATION = (
    *("iou_p", "iou_q", "hausdorff_p", "hausdorff_q", "mean_distance_p", "mean_distance_q"),
    *("input_iou_p", "input_iou_q", "rms_strain_p", "rms_strain_q", "max_strain_p", "max_strain_q"),
)
CENTRE_LINES = (
    "cldice",
    "centreline_precision_p",
    "centreline_precision_q",
    "centreline_recall_p",
    "centreline_recall_q",
)
FIDELITY = ("change_ratio", "bending_p", "bending_q", "direction_p", "direction_q", *CENTRE_LINES)
RESIDUALS = ("overlap", "gap", "hinge")


def _rejected(reason: str, message: str) -> Artifact:
    return Artifact({}, {"status": "rejected", "reason": reason, "message": message})


def items(progress: Progress) -> list[WorkItem]:
    """A work item for each pair of the shortlist, the most promising first."""
    recipe, refined = progress.recipes["construct"], progress.finished("refine")
    modes = {item.members[0]: item for item in progress.finished("modes")}
    bent = {item.members: item for item in progress.finished("bend")}
    work = []
    for position in shortlisted(progress):
        item = refined[position]
        p, q = item.members
        names = (progress.items[p].name, progress.items[q].name)
        spec = ((item.spec[0], names[0]), (item.spec[1], names[1]))
        keys, sources = [item.key], [*item.sources, item.reference]
        if (bend := bent.get(item.members)) is not None:
            keys.append(bend.key)
            sources += [modes[p].reference, modes[q].reference, bend.reference]
        work.append(recipe.item(recipe.parts(keys, names), sources, spec=spec, members=(p, q)))
    return work


def certified(progress: Progress) -> list[WorkItem]:
    """The finished constructions whose certificates passed, in order."""
    return [item for item in progress.finished("construct") if progress.read(item).document["status"] == "certified"]


def least_deformed(progress: Progress, count: int) -> list[WorkItem]:
    """The ``count`` certified constructions of greatest IoU of the worse shape, best first."""

    def iou(item: WorkItem) -> float:
        document = progress.read(item).document
        return min(float(document["iou_p"]), float(document["iou_q"]))

    return sorted(certified(progress), key=iou, reverse=True)[:count]


def _outlines(artifact: Artifact) -> Mapping[str, Any]:
    return {name: geometry.wkb.outline_wkb(np.asarray(points)) for name, points in artifact.arrays.items()}


def _row(artifact: Artifact) -> Mapping[str, Any]:
    row = {name: value for name, value in artifact.document.items() if name != "riot"}
    if "iou_p" in row:
        row["iou"] = min(row["iou_p"], row["iou_q"])
        row["input_iou"] = min(row["input_iou_p"], row["input_iou_q"])
        row["rms_strain"] = max(row["rms_strain_p"], row["rms_strain_q"])
    return row


RATIO, OF_L_C, ANGLE, AREA = "1", "L_c = 2*sqrt(pi)", "rad", "unit-area frame"

STAGE = Stage(
    name="construct",
    unit="pairs",
    after=("shortlist", "bend"),
    parameters=("construct", "refine.reach", "bend.judged", "bend.limbs"),
    items=items,
    run=run,
    scope="pair",
    known_after="shortlist",
    at_most=lambda config: config.select.constructed,
    tables=(
        TableColumns(
            "transforms",
            (
                Column("status", "string", "certified, approximate (not exact: the paper's method), or rejected"),
                Column("reason", "string", "why it was rejected, one word"),
                Column("message", "string", "why it was rejected, in words"),
            ),
            lambda artifact: artifact.document,
            after="class_j",
        ),
        TableColumns(
            "transforms",
            (
                Column("n", "int8", "pieces", "count"),
                Column("iou", "float64", "intersection over union with what is cut, of the worse shape", RATIO),
                Column("iou_p", "float64", "of P with its input, or with what that was bent to", RATIO),
                Column("iou_q", "float64", "of Q with its input, or with what that was bent to", RATIO),
                Column("input_iou", "float64", "with the input before it was bent, of the worse shape", RATIO),
                Column("input_iou_p", "float64", "of P with its input before it was bent", RATIO),
                Column("input_iou_q", "float64", "of Q with its input before it was bent", RATIO),
                Column("rms_strain", "float64", "root mean square of the strain of the more bent shape", RATIO),
                Column("rms_strain_p", "float64", "of P", RATIO),
                Column("rms_strain_q", "float64", "of Q", RATIO),
                Column("max_strain_p", "float64", "greatest strain in P but for 0.2 % of its area", RATIO),
                Column("max_strain_q", "float64", "greatest strain in Q but for 0.2 % of its area", RATIO),
                Column("bound_p", "float64", "upper bound of iou_p for the trunks used", RATIO),
                Column("bound_q", "float64", "upper bound of iou_q for the trunks used", RATIO),
                Column(
                    "change_ratio",
                    "float64",
                    "(1 − iou) / (1 − bound), the greater of P's and Q's; null = bound near 1",
                    RATIO,
                ),
                Column("hausdorff_p", "float64", "symmetric Hausdorff distance of P's outlines", OF_L_C),
                Column("hausdorff_q", "float64", "symmetric Hausdorff distance of Q's outlines", OF_L_C),
                Column("mean_distance_p", "float64", "mean distance of P's outlines", OF_L_C),
                Column("mean_distance_q", "float64", "mean distance of Q's outlines", OF_L_C),
                Column("bending_p", "float64", "bending energy of P's outline over the input's", RATIO),
                Column("bending_q", "float64", "bending energy of Q's outline over the input's", RATIO),
                Column(
                    "direction_p", "float64", "mean angle of P's outline to the input's at corresponding points", ANGLE
                ),
                Column(
                    "direction_q", "float64", "mean angle of Q's outline to the input's at corresponding points", ANGLE
                ),
                Column(
                    "cldice",
                    "float64",
                    "centre-line Dice of the worse shape: 1 if it keeps every limb of its input and adds none",
                    RATIO,
                ),
                Column("centreline_precision_p", "float64", "share of P's centre line inside its input", RATIO),
                Column("centreline_precision_q", "float64", "share of Q's centre line inside its input", RATIO),
                Column("centreline_recall_p", "float64", "share of the input's centre line inside P", RATIO),
                Column("centreline_recall_q", "float64", "share of the input's centre line inside Q", RATIO),
                Column("overlap_p", "float64", "certificate: overlap of P's pieces", AREA),
                Column("overlap_q", "float64", "certificate: overlap of Q's pieces", AREA),
                Column("gap_p", "float64", "certificate: area that P's pieces leave open", AREA),
                Column("gap_q", "float64", "certificate: area that Q's pieces leave open", AREA),
                Column("hinge_p", "float64", "certificate: greatest distance at a hinge of P", AREA),
                Column("hinge_q", "float64", "certificate: greatest distance at a hinge of Q", AREA),
            ),
            _row,
        ),
        TableColumns(
            "transforms",
            (
                Column("outline_p", "polygon", "outline that the pieces make as P, in P's frame, as WKB", AREA),
                Column("outline_q", "polygon", "outline that the pieces make as Q, in Q's frame, as WKB", AREA),
            ),
            _outlines,
        ),
    ),
)

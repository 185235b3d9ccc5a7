"""The command `riot make A B -o DIR`: the transform of two silhouettes, certified, with pictures and films. Ours."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from riot.cli.complaints import doubtful_outline, poor_likeness
from riot.cli.inputs import pair_stem, quality_facts, read_inputs
from riot.cli.make_options import POOR, Wishes, wishes_of
from riot.cli.make_options import add_options as add_options
from riot.cli.output import Output
from riot.cli.parser import DONE
from riot.cli.show import transform_facts, transform_lines
from riot.cli.transform_files import SUFFIXES, write_transform
from riot.construction.pins import load_pins
from riot.construction.plan import ConstructionPlan
from riot.construction.plan_search import alternatives
from riot.construction.plan_transform import construct_plan
from riot.construction.stiff import load_stiff
from riot.construction.trunk_choice import construct, construct_from
from riot.draw import texture  # lazy: what paints takes a second to import
from riot.draw.ffmpeg import film_writer
from riot.draw.piece_image import NO_IMAGES, PieceImages
from riot.draw.texture.names import Side
from riot.errors import TrunkError
from riot.fabricate.export.folder import check_files, check_folder, new_folder
from riot.geometry.shape import Shape
from riot.kernels.warm import compile_used
from riot.motion.planner import with_motion
from riot.parameters import (
    ConstructParameters,
    CrsParameters,
    MotionParameters,
    RefineParameters,
    ShapeParameters,
    TrunkParameters,
)
from riot.scores.crs import crs
from riot.scores.qcrs import qcrs
from riot.transform.certificate import certify
from riot.transform.deformation import overlap_ratios
from riot.transform.history import History
from riot.transform.provenance import file_digest, record_history
from riot.transform.transform import Transform


def run(chosen: argparse.Namespace, output: Output) -> int:
    """See `riot.cli.command.CommandModule`."""
    wishes = wishes_of(chosen)
    if ".mp4" in wishes.films:
        film_writer()
    shapes = read_inputs(chosen.a, chosen.b)
    doubts = [
        doubt
        for path, shape in zip((chosen.a, chosen.b), shapes, strict=True)
        for doubt in doubtful_outline(path, shape)
    ]
    transform = make(chosen.a, chosen.b, chosen.output, wishes, output, shapes)
    poor = min(overlap_ratios(transform)) < chosen.min_iou
    for complaint in [*doubts, *([poor_likeness(transform, chosen.min_iou)] if poor else [])]:
        output.complain(complaint)
    return POOR if poor or doubts else DONE


def make(
    path_a: Path, path_b: Path, folder: Path, wishes: Wishes, output: Output, shapes: tuple[Shape, Shape]
) -> Transform:
    """Construct the transform of two silhouettes, read as ``shapes``, and write it, pictures and films to ``folder``.

    Returns it.
    Raises `riot.errors.TrunkError` if there is no trunk pair of the rank that is wished for.
    """
    films, name = wishes.films, pair_stem(path_a, path_b)
    # What can be known is told before the long work.
    if wishes.pictures and "q" in wishes.pictures and wishes.mirror_q == "no":
        output.note("B's colours are on the back, where they are seen mirrored: --mirror-q has them read there")
    a, b = shapes
    check_folder(folder, replace_files=True)
    check_files([folder / f"{name}{suffix}" for suffix in (*SUFFIXES, *films)], replace_files=wishes.replace_files)
    compile_used(output.note, __name__)
    output.note("constructs the transform")
    parameters = ConstructParameters(method=wishes.method)
    sides = {"no": (False,), "yes": (True,), "best": (False, True)}[wishes.mirror_q]
    transforms = [_constructed(a, b.mirrored() if back else b, back, parameters, wishes) for back in sides]
    transform = max(transforms, key=lambda made: (certify(made).passed, min(overlap_ratios(made))))
    inputs = transform.input_p, transform.input_q
    scores = {"qcrs": qcrs(*inputs).score, "crs": crs(*inputs).score}
    if certify(transform).passed:
        transform = with_motion(transform)
    transform = replace(transform, history=_history(path_a, path_b, parameters, wishes))
    facts = transform_facts(transform)
    images = _piece_images(transform, wishes.pictures, {"p": path_a, "q": path_b})
    output.note("draws it" if not films else "draws and films it")
    with new_folder(folder, replace_files=True) as temporary:
        files = []
        for path in write_transform(transform, temporary / name, films, images):
            files.append(folder / path.name)
            output.detail(f"{path.name} is ready")
    # After the files: a terminal that takes no more costs nothing then.
    output.show(f"QCRS {scores['qcrs']:.3f}, CRS {scores['crs']:.3f}", *transform_lines(transform, facts))
    output.show(*map(str, files))
    qualities = [None if shape.quality is None else quality_facts(shape.quality) for shape in shapes]
    output.document({**scores, **facts, "readings": qualities, "files": files})
    return transform


def _constructed(a: Shape, b: Shape, back: bool, parameters: ConstructParameters, wishes: Wishes) -> Transform:
    """The transform that is wished for; ``back``: b is mirrored, to be read on the back."""
    pins = None if wishes.pins is None else load_pins(wishes.pins, a, b)
    stiff = None if wishes.stiff is None else load_stiff(wishes.stiff, a, b)
    if wishes.rank is None:
        transform = construct(
            a, b, parameters=parameters, pins=pins, pieces=wishes.pieces, bend=wishes.bend, stiff=stiff
        )
    else:
        plan = _ranked(alternatives(a, b, pieces=wishes.pieces), wishes.rank)
        if wishes.bend is None:
            transform = construct_plan(plan, parameters, pins)
        else:
            transform = construct_from([plan], [], parameters, pins=pins, bend=wishes.bend, stiff=stiff)
    return replace(transform, mirrored_q=back)


def _history(path_a: Path, path_b: Path, parameters: ConstructParameters, wishes: Wishes) -> History:
    pins = None if wishes.pins is None else file_digest(wishes.pins)
    steps: dict[str, dict[str, Any]] = {
        "ingest": asdict(ShapeParameters()),
        "trunks": asdict(TrunkParameters()),
        "crs": asdict(CrsParameters()),
        "refine": asdict(RefineParameters()),
        "construct": {**asdict(parameters), "rank": wishes.rank, "pins": pins, "pieces": wishes.pieces},
        "motion": asdict(MotionParameters()),
    }
    if wishes.bend is not None:
        stiff = None if wishes.stiff is None else file_digest(wishes.stiff)
        steps["bend"] = {**asdict(wishes.bend), "stiff": stiff}
    return record_history("riot make", (path_a, path_b), steps)


def _ranked(plans: Sequence[ConstructionPlan], rank: int) -> ConstructionPlan:
    if not 1 <= rank <= len(plans):
        raise TrunkError(f"there is no trunk pair of rank {rank}: there are {len(plans)}; `riot trunks A B` lists them")
    return plans[rank - 1]


def _piece_images(
    transform: Transform, pictures: Mapping[Side, Path] | None, masks: Mapping[Side, Path]
) -> PieceImages:
    if not pictures:
        return NO_IMAGES
    textures = texture.paint.find_textures(transform, pictures, masks)
    return texture.sample.piece_images(transform, textures)

"""The command `riot show FILE.riot`: the numbers of a transform, its certificate and its motion; a film. Ours."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import riot.transform  # lazy: what finds centre lines takes half a second to import
from riot import draw  # lazy: most calls film nothing
from riot.cli.output import Output
from riot.cli.parser import Parser
from riot.cli.table import Table
from riot.motion.planner import motion_of
from riot.transform.certificate import certify
from riot.transform.deformation import Deformation, change_ratio, measure_deformation
from riot.transform.fidelity import bending_ratio, direction_error
from riot.transform.history import to_document
from riot.transform.motion import Motion
from riot.transform.provenance import describe_history
from riot.transform.riot_file import load
from riot.transform.transform import Transform
from riot.types import FloatArray

SIDES = ("p", "q")

ROWS = (
    ("IoU with the input", "iou", ".4f"),
    ("bound of the IoU", "bound", ".4f"),
    ("Hausdorff distance / L_c", "hausdorff", ".4f"),
    ("mean distance / L_c", "mean_distance", ".4f"),
    ("change / least change", "change", ".3f"),
    ("bending / input's", "bending", ".3f"),
    ("directions off, degrees", "direction_error", ".2f"),
    ("centre line kept", "centreline_recall", ".3f"),
    ("centre line inside", "centreline_precision", ".3f"),
    ("overlap", "overlap", ".1e"),
    ("gaps", "gap", ".1e"),
    ("hinges apart", "hinge", ".1e"),
)
"""Rows of the table: words, the name of the number in the JSON document, and how it is written.

The rows of centre lines are there only if they are asked for.
"""

BENT_ROWS = (
    ("IoU with the bent input", "iou", ".4f"),
    ("IoU with the input itself", "input_iou", ".4f"),
    ("strain, root mean square", "rms_strain", ".2%"),
    ("strain, greatest", "max_strain", ".2%"),
    *ROWS[1:],
)
"""The same for shapes that are bent first, with which the rows after these compare."""


def add_options(parser: Parser) -> None:
    """See `riot.cli.command.CommandModule`."""
    parser.add_argument("file", type=Path, metavar="FILE.riot", help="a transform, as `riot make` writes it")
    parser.add_argument(
        "--history", action="store_true", help="print pictures, parameters, code and libraries that made it instead"
    )
    parser.add_argument(
        "-o",
        "--film",
        type=Path,
        metavar="FILM",
        help="film the motion too, as an animated GIF (.gif) or, by ffmpeg or the extra 'film', as .mp4",
    )
    parser.shared.description = "With --verbose or --json the numbers include those of centre lines."


def run(chosen: argparse.Namespace, output: Output) -> int:
    """See `riot.cli.command.CommandModule`."""
    transform = load(chosen.file)
    if chosen.film is not None:
        draw.film.write_film(transform, chosen.film)
    if not chosen.history:
        facts = transform_facts(transform, centre_lines=output.verbose or output.json)
        output.facts(facts, *transform_lines(transform, facts))
    elif transform.history is None:
        untold = f"{chosen.file} tells no history: it was written by an earlier version, or by hand"
        output.facts({"history": None}, untold)
    else:
        output.facts({"history": to_document(transform.history)}, *describe_history(transform.history))
    return 0


def transform_facts(transform: Transform, *, centre_lines: bool = True) -> dict[str, Any]:
    """The numbers of a transform: of each input, of the certificate, and of the motion, None unless it is certified.

    Without ``centre_lines`` the numbers of these are left out, and so is the time that it takes to find them.
    """
    deformation, certificate = measure_deformation(transform), certify(transform)
    inputs = []
    for side in SIDES:
        shape, outline = getattr(transform, side), getattr(transform, f"outline_{side}")()
        iou, bound = getattr(deformation, f"iou_{side}"), getattr(transform, f"bound_{side}")
        assembly = getattr(certificate, side)
        inputs.append(
            {
                "name": shape.name,
                "iou": iou,
                "bound": bound,
                "hausdorff": getattr(deformation, f"hausdorff_{side}"),
                "mean_distance": getattr(deformation, f"mean_distance_{side}"),
                "change": change_ratio(iou, bound),
                "bending": bending_ratio(outline, shape.points),
                "direction_error": math.degrees(direction_error(outline, shape.points)),
                **(_centre_line_facts(outline, shape.points) if centre_lines else {}),
                "overlap": assembly.overlap,
                "gap": assembly.gap,
                "hinge": assembly.hinge,
            }
            | _bend_facts(transform, deformation, side)
        )
    return {
        "pieces": len(transform),
        "inputs": inputs,
        "certificate": {"passed": certificate.passed, "failure": certificate.failure or None},
        "motion": _motion_facts(motion_of(transform)) if certificate.passed else None,
    }


def transform_lines(transform: Transform, facts: Mapping[str, Any]) -> Iterator[str | Table]:
    """The ``facts`` of a transform for a terminal."""
    names = [numbers["name"] for numbers in facts["inputs"]]
    title = f"{' ⇄ '.join(names)}, {facts['pieces']} pieces"
    rows = []
    for words, name, form in BENT_ROWS if "input_iou" in facts["inputs"][0] else ROWS:
        numbers = [number[name] for number in facts["inputs"] if name in number]
        if not numbers:
            continue
        rows.append((words, *("–" if math.isnan(number) else format(number, form) for number in numbers)))
    yield Table(("", *names), rows, title, left=("",))
    if not facts["certificate"]["passed"]:
        yield f"certificate: failed ({facts['certificate']['failure']})"
        return
    yield "certificate: passed"
    motion = motion_of(transform)
    lifting = "" if motion.flat else f", lifting at {', '.join(map(str, motion.lifted))}"
    yield f"motion: {motion.words} ({motion.search}, open at hinge {motion.open_hinge}{lifting})"


def _bend_facts(transform: Transform, deformation: Deformation, side: str) -> dict[str, float]:
    if transform.bend_p is None and transform.bend_q is None:
        return {}
    return {name: getattr(deformation, f"{name}_{side}") for name in ("input_iou", "rms_strain", "max_strain")}


def _centre_line_facts(outline: FloatArray, reference: FloatArray) -> dict[str, float]:
    lines = riot.transform.centreline.centre_line_overlap(outline, reference)
    return {"centreline_recall": lines.recall, "centreline_precision": lines.precision}


def _motion_facts(motion: Motion) -> dict[str, Any]:
    return {
        "flat": motion.flat,
        "words": motion.words,
        "search": motion.search,
        "open_hinge": motion.open_hinge,
        "lifted": list(motion.lifted),
    }

"""The files of a stack: a folder a slice, pictures and a list of the whole; the same bytes every time. Ours."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from riot.errors import ModelError
from riot.fabricate.export.flat import write_flat_files
from riot.fabricate.export.folder import new_folder
from riot.fabricate.export.solids import write_puzzle
from riot.slices.cut import Stack
from riot.slices.make import Puzzle, SliceOutcome
from riot.slices.picture import draw_overview, draw_slices
from riot.transform.deformation import overlap_ratios
from riot.transform.riot_file import save

FORMAT, VERSION = "riot-set", 1

DIGITS = 6
"""Decimals of lengths (mm), areas (mm²) and ratios in ``set.json``."""


def write_set(
    stack: Stack,
    outcomes: Sequence[SliceOutcome],
    folder: Path,
    more: Callable[[Puzzle], Sequence[Callable[[Path], None]]] | None = None,
) -> list[Path]:
    """Write all files of a stack into a new folder, or none; returns what was written.

    ``slice-K-COUNTERPART/`` a slice that is made, as `riot.fabricate.export.solids.write_puzzle` with the ``.riot``
    file and outlines for a laser, ``overview.png``, ``slices.png``, ``slices.svg``, and ``set.json``. ``more`` gives
    functions that write further files of a puzzle into the folder that they are given.

    Raises ModelError ``nothing-made`` if no slice is, OSError if the folder cannot be written, is a file, or holds
    something already.
    """
    if all(outcome.puzzle is None for outcome in outcomes):
        reasons = "; ".join(f"slice {outcome.slice.number}: {outcome.reason}" for outcome in outcomes)
        raise ModelError("nothing-made", f"{stack.name}: no slice could be made: {reasons}")
    with new_folder(folder) as temporary:
        for outcome in outcomes:
            if outcome.puzzle is not None:
                _write_puzzle(outcome.puzzle, temporary / folder_name(outcome), more)
        draw_overview(stack, outcomes, temporary / "overview.png")
        for suffix in (".png", ".svg"):
            draw_slices(outcomes, temporary / f"slices{suffix}")
        document = json.dumps(set_document(stack, outcomes), indent=1, ensure_ascii=False)
        (temporary / "set.json").write_text(f"{document}\n", encoding="utf-8", newline="\n")
    return sorted(path for path in folder.rglob("*") if path.is_file())


def folder_name(outcome: SliceOutcome) -> str:
    """Of a slice that is made: ``slice-3-heart``; what no file name should hold is replaced."""
    assert outcome.puzzle is not None
    name = re.sub(r"[^\w.-]+", "_", outcome.puzzle.counterpart)
    return f"slice-{outcome.slice.number}-{name}"


def _write_puzzle(
    puzzle: Puzzle, folder: Path, more: Callable[[Puzzle], Sequence[Callable[[Path], None]]] | None
) -> None:
    built = puzzle.built

    def transform(folder_: Path) -> None:
        save(puzzle.transform, folder_ / "puzzle.riot")

    def laser(folder_: Path) -> None:
        write_flat_files(built.design, folder_, dxf=False)

    write_puzzle(
        built.design, built.parts, built.certificate, folder, [transform, laser, *(more(puzzle) if more else ())]
    )


def set_document(stack: Stack, outcomes: Sequence[SliceOutcome]) -> dict[str, Any]:
    """What ``set.json`` holds: how the object was cut, and of every slice its areas, counterpart, numbers or reason."""
    return {
        "format": FORMAT,
        "version": VERSION,
        "model": stack.name,
        "along": stack.along,
        "mm_per_file_unit": stack.scale,
        "thickness_mm": stack.thickness,
        "height_mm": round(stack.height, DIGITS),
        "stack_iou": round(stack.iou, DIGITS),
        "made": sum(outcome.puzzle is not None for outcome in outcomes),
        "slices": [_entry(outcome) for outcome in outcomes],
    }


def _entry(outcome: SliceOutcome) -> dict[str, Any]:
    cut, puzzle = outcome.slice, outcome.puzzle
    entry: dict[str, Any] = {
        "slice": cut.number,
        "low_mm": round(cut.low, DIGITS),
        "high_mm": round(cut.high, DIGITS),
        "area_mm2": round(cut.area, DIGITS),
        "filled_mm2": round(cut.filled, DIGITS),
        "left_out_mm2": round(cut.lost, DIGITS),
        "tried_in_vain": [{"counterpart": tried.counterpart, "reason": tried.reason} for tried in outcome.attempts],
    }
    if puzzle is None:
        return {**entry, "reason": outcome.reason}
    design, transform = puzzle.built.design, puzzle.transform
    iou_p, iou_q = overlap_ratios(transform)
    return {
        **entry,
        "folder": folder_name(outcome),
        "counterpart": puzzle.counterpart,
        "qcrs": round(puzzle.qcrs, DIGITS),
        "iou_slice": round(iou_p, DIGITS),
        "iou_counterpart": round(iou_q, DIGITS),
        "pieces": len(transform),
        "motion": design.motion.words,
        "size_mm": round(design.parameters.size_mm, DIGITS),
        "place_mm": [round(float(value), DIGITS) for value in transform.p.to_source[:, 2]],
        "pins": sum(pin.count for pin in design.pins),
        "sleeves": design.sleeves,
        "certified": puzzle.certificate.passed,
        "narrowest_mm": round(puzzle.certificate.wall, 3),
        "changed": list(puzzle.built.changes),
        "warnings": list(design.warnings),
    }

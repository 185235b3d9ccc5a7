"""The command `riot slices MODEL --count 7 --thickness 20 --into A.png,B.png -o DIR`: a solid as a stack of puzzles.

Exit codes: 0 every slice is made, 3 some are not (the table says why, and the others are written), 2 could not be done.
Ours.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from riot import slices  # lazy: what cuts and builds takes a second to import
from riot.cli.output import Output
from riot.cli.parser import EXIT_CODES, Parser
from riot.cli.size_options import add_sizes, chosen_sizes
from riot.cli.table import Table
from riot.errors import TrunkError
from riot.fabricate import export
from riot.fabricate.export.folder import check_folder
from riot.geometry.shape import Shape
from riot.geometry.silhouette import read
from riot.kernels.warm import compile_used
from riot.parameters import ShapeParameters
from riot.transform.deformation import overlap_ratios

if TYPE_CHECKING:
    Search = Callable[[Sequence[Shape], int], Sequence[slices.Shortlist]]
    # The shortlists of some slices' shapes, each of so many at most.

MADE, SOME_FAILED = 0, 3
CANDIDATES = 10

_DECIDED = ("size_mm", "thickness_mm")
"""Parameters of fabrication that the cut decides for every slice."""


def add_options(parser: Parser) -> None:
    """See `riot.cli.command.CommandModule`."""
    parser.add_argument("model", type=Path, metavar="MODEL", help="a watertight solid: STL, 3MF or OBJ, in mm")
    parser.add_argument(
        "--into", nargs="+", metavar="A.png,B.png", help="pictures or SVG files to become, apart by commas or spaces"
    )
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="DIR", help="a folder that is not there yet"
    )
    parser.add_argument("--count", type=int, metavar="N", help="how many slices")
    parser.add_argument("--thickness", type=float, metavar="MM", help="of a slice, in whole layers of the printer")
    parser.add_argument(
        "--size", type=float, metavar="MM", help="height of the object along the cut; default: count times thickness"
    )
    parser.add_argument("--along", choices=("auto", "x", "y", "z"), default="auto", help="direction to stack in")
    parser.add_argument("--distinct", action="store_true", help="no two slices become the same shape")
    parser.add_argument(
        "--candidates",
        type=int,
        default=CANDIDATES,
        metavar="K",
        help="try so many of a slice's best counterparts by QCRS (default: %(default)s)",
    )
    parser.add_argument("--fix", action="store_true", help="change pin or wall where a slice cannot be made as is")
    parser.add_argument("--paper", action="store_true", help="an assembly page and pictures of every slice too")
    add_sizes(parser, without=_DECIDED)
    parser.flags |= {name: f"--{name.removesuffix('_mm')}" for name in _DECIDED}
    parser.exit_codes = {**EXIT_CODES, SOME_FAILED: "Some slices could not be made; the others are written."}


def run(chosen: argparse.Namespace, output: Output) -> int:
    """See `riot.cli.command.CommandModule`."""
    if not chosen.into:
        raise TrunkError("there is nothing to become: give pictures with --into A.png,B.png")
    return slice_model(chosen, output, given(chosen.into))


def given(words: Sequence[str]) -> Search:
    """Counterparts in the files that ``--into`` names; raises `riot.errors.SilhouetteError`, OSError."""
    shapes = _named([path for word in words for path in _paths(word)])

    def search(cuts: Sequence[Shape], keep: int) -> Sequence[slices.Shortlist]:
        return slices.shortlists(cuts, shapes, keep)

    return search


def _paths(word: str) -> list[Path]:
    """A file, or several, apart by commas."""
    return [Path(word)] if Path(word).exists() else [Path(name) for name in word.split(",") if name.strip()]


def _named(paths: Sequence[Path]) -> list[Shape]:
    """The shapes in files, each file once, named so that they can be told apart."""
    unique = list(dict.fromkeys(paths))
    stems = [path.stem for path in unique]
    return [
        read(path).renamed(stem if stems.count(stem) == 1 else str(path))
        for path, stem in zip(unique, stems, strict=True)
    ]


def slice_model(
    chosen: argparse.Namespace, output: Output, search: Search, sampling: ShapeParameters | None = None
) -> int:
    """Do what was ``chosen`` (`add_options`), with the counterparts that ``search`` finds; returns the exit code.

    ``sampling``: how outlines of slices become shapes. Raises what the command tells; then nothing is written.
    """
    check_folder(chosen.output)
    parameters = chosen_sizes(chosen)
    if chosen.candidates < 1:
        raise TrunkError(f"--candidates {chosen.candidates}: try one at least")
    how = slices.Cut(chosen.count, chosen.thickness, chosen.size, chosen.along, parameters.layer_mm)
    stack = slices.cut(slices.read_model(chosen.model), how)
    compile_used(output.note, __name__)
    # With so many candidates each, as many slices as there are can take one of their own.
    keep = max(chosen.candidates, len(stack.slices)) if chosen.distinct else chosen.candidates
    outcomes = slices.make_puzzles(
        stack,
        lambda shapes: search(shapes, keep),
        parameters,
        distinct=chosen.distinct,
        mend=chosen.fix,
        sampling=sampling,
        note=output.note,
    )
    slices.files.write_set(stack, outcomes, chosen.output, _paperwork if chosen.paper else None)
    document = {"folder": chosen.output, "set": slices.files.set_document(stack, outcomes)}
    output.facts(document, _table(stack, outcomes), str(chosen.output))
    return MADE if all(outcome.puzzle is not None for outcome in outcomes) else SOME_FAILED


def _paperwork(puzzle: slices.Puzzle) -> list[Callable[[Path], None]]:
    def write(folder: Path) -> None:
        export.paperwork.write_paperwork(puzzle.built.design, folder, dxf=False)

    return [write]


def _table(stack: slices.Stack, outcomes: Sequence[slices.SliceOutcome]) -> Table:
    title = (
        f"{stack.name}: {len(stack.slices)} slices of {stack.thickness:g} mm along {stack.along}, "
        f"scaled by {stack.scale:.4g}; stack and object share {stack.iou:.1%} of both"
    )
    rows = []
    for outcome in outcomes:
        cut, puzzle = outcome.slice, outcome.puzzle
        row = [str(cut.number), *(f"{area / 100.0:.2f}" for area in (cut.area, cut.filled, cut.lost))]
        if puzzle is None:
            row += ["–", "", "", "", f"not made: {outcome.reason}"]
        else:
            ious = [f"{iou:.3f}" for iou in overlap_ratios(puzzle.transform)]
            row += [puzzle.counterpart, str(len(puzzle.transform)), *ious, "; ".join(puzzle.built.changes)]
        rows.append(row)
    columns = ("slice", "cm²", "filled", "left out", "becomes", "pieces", "IoU slice", "IoU becomes", "remarks")
    return Table(columns, rows, title, left=("becomes", "remarks"))

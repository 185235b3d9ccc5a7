"""The command `riot print FILE.riot -o DIR`: the files of a puzzle, certified. Ours."""

from __future__ import annotations

import argparse
import json
import math
from pathlib import Path

from riot.cli.common_options import add_force
from riot.cli.output import Output
from riot.cli.parser import Parser
from riot.cli.size_options import add_sizes, chosen_sizes
from riot.cli.table import Table
from riot.draw import texture  # lazy: what paints takes a second to import
from riot.draw.texture.names import PATTERNS, SIDES
from riot.errors import FabricationError
from riot.fabricate import export
from riot.fabricate.advice import strengthening
from riot.fabricate.certificate import MENDED, BuiltPuzzle, FabricationCertificate, build, fix, way_out
from riot.fabricate.export.folder import check_folder
from riot.fabricate.export.solids import write_puzzle
from riot.fabricate.plates import check_bed
from riot.fabricate.tray import check_tray, check_tray_bed, tray_parts
from riot.kernels.warm import compile_used
from riot.parameters import FabricationParameters
from riot.transform.riot_file import load
from riot.transform.transform import Transform


def add_options(parser: Parser) -> None:
    """See `riot.cli.command.CommandModule`."""
    parser.add_argument("file", type=Path, metavar="FILE.riot", help="a transform, as `riot make` writes it")
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="DIR", help="a folder that is not there yet, or is empty"
    )
    add_force(parser)
    add_sizes(parser)
    parser.add_argument("--tray", action="store_true", help="two trays to keep the puzzle in, one for either shape")
    parser.add_argument("--fix", action="store_true", help="change pin, size or wall if it cannot be made as is")
    parser.add_argument(
        "--paper",
        action="store_true",
        help="laser files (SVG), an assembly page and pictures too; implied by those below",
    )
    parser.add_argument("--dxf", action="store_true", help="laser files as DXF too (needs the extra 'print')")
    parser.add_argument(
        "--texture-p", type=Path, metavar="PICTURE", help="paint the front with the picture of the first"
    )
    parser.add_argument("--texture-q", type=Path, metavar="PICTURE", help="paint the back with that of the second")
    for side in SIDES:
        parser.add_argument(
            f"--mask-{side}",
            type=Path,
            metavar="PICTURE",
            help=f"what is object in --texture-{side}, if it is a picture without transparency: one of the same size",
        )
    parser.add_argument("--pattern", choices=PATTERNS, help="paint sides without a picture with a pattern")


def run(chosen: argparse.Namespace, output: Output) -> int:
    """See `riot.cli.command.CommandModule`."""
    parameters = chosen_sizes(chosen)
    pictures, masks = (
        {side: path for side in SIDES if (path := getattr(chosen, f"{name}_{side}"))} for name in ("texture", "mask")
    )
    transform = load(chosen.file)
    check_folder(chosen.output, replace_files=chosen.replace_files)
    check_bed(transform, parameters)
    if chosen.tray:
        check_tray_bed(transform, parameters)
    if "q" in pictures and not transform.mirrored_q:
        name = transform.q.name or "Q"
        output.note(f"the back shows {name} mirrored: `riot make --mirror-q` cuts it to be read there")
    painted = bool(pictures or chosen.pattern)
    textures = texture.paint.find_textures(transform, pictures, masks, chosen.pattern) if painted else {}
    if parameters.inlay and len(textures) == 1:
        (plain,) = set(SIDES) - set(textures)
        face = "front" if plain == "p" else "back"
        output.note(f"the {face} gets no inlay: --texture-{plain} or --pattern paints it")
    paper = chosen.paper or chosen.dxf or (bool(textures) and not parameters.inlay)

    def write_paper(folder: Path) -> None:
        export.paperwork.write_paperwork(puzzle.design, folder, textures, drawing=drawing, dxf=chosen.dxf, trays=trays)

    compile_used(output.note, __name__)
    output.note("designs the pieces and proves that they move")
    puzzle = _certified(transform, parameters, chosen.fix, output)
    if paper:
        output.show(*(f"warning: {words}" for words in export.flat.laser_notes(puzzle.design)))
    output.note("writes the files")
    drawing = export.drawing.drawing_of(puzzle.design, textures)
    trays = tray_parts(puzzle.design) if chosen.tray else ()
    checks = [check_tray(puzzle.design, tray) for tray in trays]
    if failures := [words for check in checks for words in check.failures]:
        raise FabricationError("uncertified", "; ".join(failures))
    output.show(*(check.words for check in checks))
    files = write_puzzle(
        puzzle.design,
        puzzle.parts,
        puzzle.certificate,
        chosen.output,
        [write_paper] if paper else (),
        drawing=drawing,
        trays=trays,
        replace_files=chosen.replace_files,
    )
    document = json.loads((chosen.output / "parts.json").read_bytes())
    output.facts({"changes": puzzle.changes, "puzzle": document, "files": files}, *map(str, files))
    return 0


def _certified(transform: Transform, parameters: FabricationParameters, mend: bool, output: Output) -> BuiltPuzzle:
    """The puzzle; if it fails, an error that says with which sizes it has been built and passes."""
    try:
        puzzle = (fix if mend else build)(transform, parameters)
        _show(puzzle, output)
        if output.verbose and puzzle.certificate.passed and (words := strengthening(puzzle.design)):
            output.show(f"advice: {words}")
        if puzzle.certificate.passed:
            return puzzle
        error = FabricationError("uncertified", "; ".join(puzzle.certificate.failures))
    except FabricationError as refusal:
        error = refusal
    if not mend and (error.reason == "uncertified" or error.parameter in MENDED):
        output.note("looks for sizes at which it can be made")
        error = FabricationError(
            error.reason, f"{error}. Way out: {way_out(transform, parameters)}", error.parameter, error.value
        )
    raise error


def _show(puzzle: BuiltPuzzle, output: Output) -> None:
    certificate = puzzle.certificate
    output.show(_table(certificate), *certificate.words())
    output.show(*(f"changed: {words}" for words in puzzle.changes))
    output.show(*(f"warning: {words}" for words in puzzle.design.warnings))
    output.show(f"certificate: {'passed' if certificate.passed else 'failed'}")


def _table(certificate: FabricationCertificate) -> Table:
    rows = [
        (
            check.name,
            str(check.count),
            str(check.components),
            str(check.genus),
            f"{check.volume / 1000.0:.3f}",
            "" if math.isnan(check.wall) else f"{check.wall:.2f}",
        )
        for check in certificate.parts
    ]
    columns = ("part", "count", "solids", "handles", "volume cm³", "narrowest mm")
    return Table(columns, rows, "Fabrication", left=("part",))

"""The command `riot print FILE.riot -o DIR`: the files of a puzzle, certified. Ours."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console

from riot.cli.size_options import add_sizes, chosen_sizes, name_options
from riot.draw import texture  # lazy: what paints takes a second to import
from riot.draw.texture.names import PATTERNS, SIDES
from riot.errors import FabricationError
from riot.fabricate import export
from riot.fabricate.certificate import build, fix
from riot.fabricate.export.folder import check_folder
from riot.fabricate.export.solids import write_puzzle
from riot.fabricate.model import Design
from riot.parameters import FabricationParameters
from riot.transform.riot_file import load
from riot.transform.transform import Transform

if TYPE_CHECKING:
    Commands = argparse._SubParsersAction[argparse.ArgumentParser]

More = Callable[[Design], Sequence[Callable[[Path], None]]]
"""What else to write for a design: functions that each write into the folder they are given."""


def add_print(commands: Commands) -> None:
    """Add the command to the parser of `riot`."""
    parser = commands.add_parser("print", help="make the solids of a .riot file for a 3D printer")
    parser.add_argument("file", type=Path, metavar="FILE.riot")
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="DIR", help="a folder that is not there yet"
    )
    add_sizes(parser)
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
    parser.set_defaults(run=_print)


def print_puzzle(
    transform: Transform,
    folder: Path,
    parameters: FabricationParameters | None = None,
    *,
    mend: bool = False,
    more: More | None = None,
) -> list[Path]:
    """Design, verify, print the certificate on the terminal, write the files; returns them.

    With ``mend`` the pin may get thinner, the size larger, and knuckles thicker.

    Raises `riot.errors.FabricationError` with the reason if the puzzle cannot be made, OSError if the folder
    cannot be written; then nothing is written.
    """
    check_folder(folder)
    puzzle = (fix if mend else build)(transform, parameters)
    certificate = puzzle.certificate
    Console().print(certificate.table())
    for line in (*certificate.words(), *(f"changed: {words}" for words in puzzle.changes)):
        print(name_options(line))
    for words in puzzle.design.warnings:
        print(f"warning: {name_options(words)}")
    print(f"certificate: {'passed' if certificate.passed else 'failed'}")
    if not certificate.passed:
        raise FabricationError("uncertified", "; ".join(certificate.failures))
    return write_puzzle(puzzle.design, puzzle.parts, certificate, folder, more(puzzle.design) if more else ())


def _print(chosen: argparse.Namespace) -> int:
    parameters = chosen_sizes(chosen)
    check_folder(chosen.output)
    transform = load(chosen.file)
    pictures, masks = (
        {side: path for side in SIDES if (path := getattr(chosen, f"{name}_{side}"))} for name in ("texture", "mask")
    )
    textures = texture.paint.find_textures(transform, pictures, masks, chosen.pattern)
    paper = chosen.paper or chosen.dxf or bool(textures)

    def more(design: Design) -> list[Callable[[Path], None]]:
        def write(folder: Path) -> None:
            export.paperwork.write_paperwork(design, folder, textures, dxf=chosen.dxf)

        return [write]

    written = print_puzzle(transform, chosen.output, parameters, mend=chosen.fix, more=more if paper else None)
    for path in written:
        print(path)
    return 0

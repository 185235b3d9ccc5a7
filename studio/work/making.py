"""Make the puzzle of a transform: its files in a folder of the session, and what the certificate finds, by piece."""

from __future__ import annotations

import re
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Literal

from msgspec import Struct, json

from riot.errors import RiotError
from riot.fabricate import export
from riot.fabricate.certificate import BuiltPuzzle, build, fix
from riot.fabricate.export.solids import write_puzzle
from riot.fabricate.export.stl import stl_bytes
from riot.fabricate.solid import Part
from riot.parameters import FabricationParameters
from studio.session.folder import digest_of
from studio.work.material import Files, transform
from studio.work.settings import Value

PARTS, PUZZLE, RESULT = "parts", "puzzle", "made.json"
"""In the folder of a make: every part as STL, also of one that fails; all files of one that passes; what was found."""

VERSION = 2
"""Of what is kept of a make."""

_PIECE = re.compile(r"\bpiece-(\d+)\b")
_HINGE = re.compile(r"\bhinge (\d+)\b")


class Finding(Struct, frozen=True):
    """What the certificate says of a piece or a hinge; ``parameter`` would mend it."""

    severity: Literal["failure", "warning", "fact"]
    piece: int | None
    hinge: int | None
    words: str
    parameter: str | None = None
    value: float | None = None


class PartFacts(Struct, frozen=True):
    """A part, how many there are, its size and volume, and whether its STL file is turned over: it is printed so."""

    name: str
    kind: str
    piece: int | None
    count: int
    size_mm: list[float]
    volume_mm3: float
    upside_down: bool


class Puzzle(Struct, frozen=True):
    """What was made."""

    key: str
    passed: bool
    changes: list[str]
    scale: float
    thickness: float
    findings: list[Finding]
    parts: list[PartFacts]


def make_key(digest: str, settings: Mapping[str, Value], mend: bool) -> str:
    """The name of a make: of what it is made from.

    >>> len(make_key("1f", {}, False))
    32
    """
    return digest_of(json.encode([VERSION, digest, sorted(settings.items()), mend]))


def make_puzzle(files: Files, digest: str, settings: Mapping[str, Value], mend: bool, folder: Path) -> Puzzle:
    """Build and certify a puzzle and write its files to ``folder/KEY``; what was made before is only read.

    Raises `riot.errors.ParameterError` for a setting out of its range, `riot.errors.FabricationError` for what cannot
    exist.
    """
    key = make_key(digest, settings, mend)
    target = folder / key
    if not (target / RESULT).exists():
        puzzle = (fix if mend else build)(transform(files, digest), FabricationParameters(**settings))  # type: ignore[arg-type]
        _write(puzzle, key, target)
    return json.decode((target / RESULT).read_bytes(), type=Puzzle)


def _write(puzzle: BuiltPuzzle, key: str, target: Path) -> None:
    temporary = Path(tempfile.mkdtemp(prefix=".make-", dir=target.parent))
    try:
        (temporary / PARTS).mkdir(mode=0o700)
        for part in puzzle.parts:
            (temporary / PARTS / f"{part.name}.stl").write_bytes(stl_bytes(part))
        findings = list(_findings(puzzle))
        if puzzle.certificate.passed:
            try:
                write_puzzle(
                    puzzle.design,
                    puzzle.parts,
                    puzzle.certificate,
                    temporary / PUZZLE,
                    [lambda folder: _write_paper(puzzle, folder)],
                )
            except RiotError as error:  # such as a part that is larger than the bed
                parameter = getattr(error, "parameter", "") or None
                findings.append(Finding("failure", *_place(str(error)), str(error), parameter))
        passed = (temporary / PUZZLE).exists()
        parameters = puzzle.design.parameters
        result = Puzzle(
            key,
            passed,
            list(puzzle.changes),
            puzzle.design.scale,
            parameters.height,
            findings,
            [_facts(part) for part in puzzle.parts],
        )
        (temporary / RESULT).write_bytes(json.encode(result))
        temporary.rename(target)
    except BaseException:
        shutil.rmtree(temporary, ignore_errors=True)
        raise


def _write_paper(puzzle: BuiltPuzzle, folder: Path) -> None:
    export.paperwork.write_paperwork(puzzle.design, folder, dxf=True)


def _facts(part: Part) -> PartFacts:
    piece, _ = _place(part.name)
    size = [round(length, 3) for length in part.size]
    return PartFacts(part.name, part.kind, piece, part.count, size, round(part.volume, 3), part.upside_down)


def _findings(puzzle: BuiltPuzzle) -> Iterator[Finding]:
    certificate = puzzle.certificate
    for check in certificate.parts:
        piece, _ = _place(check.name)
        for words in check.failures:
            yield Finding("failure", piece, None, words, check.mend or None)
    for hinge in certificate.hinges:
        for words in hinge.failures:
            yield Finding("failure", None, hinge.hinge, words)
    for words in certificate.motion.failures:
        yield Finding("failure", *_place(words), words)
    for words in puzzle.design.warnings:
        yield Finding("warning", *_place(words), words)
    for words in certificate.words():
        yield Finding("fact", *_place(words), words)


def _place(words: str) -> tuple[int | None, int | None]:
    """The piece and the hinge that words name, if any; ``piece-1`` is piece 0.

    >>> _place("piece-3: its corner at hinge 2 is narrow")
    (2, 2)
    """
    piece, hinge = _PIECE.search(words), _HINGE.search(words)
    return (int(piece[1]) - 1 if piece else None), (int(hinge[1]) if hinge else None)

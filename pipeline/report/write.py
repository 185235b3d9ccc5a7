"""Read a run, draw its transforms, and put the report and the gallery beside the tables."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from pipeline.report import gallery
from pipeline.report.card import card
from pipeline.report.classes import CLASSES, LEAST, classes_page
from pipeline.report.page import Rejection, page
from pipeline.report.pictures import preview, silhouettes, swing, thumb
from pipeline.report.rows import PuzzleRow, TransformRow
from pipeline.report.run import read_run
from pipeline.report.transform_page import transform_page
from pipeline.store.store import write_atomically
from pipeline.tables.outputs import new_place, replace_folder
from pipeline.tables.record import GALLERY, REPORT
from pipeline.tables.textures import read_textures
from riot.draw.piece_image import PieceImages
from riot.errors import FormatError, needs_extra
from riot.transform.riot_file import from_json
from riot.transform.transform import Transform

with needs_extra("mine"):
    from markupsafe import Markup


@dataclass(frozen=True, eq=False)
class _Drawn:
    row: TransformRow
    transform: Transform
    images: PieceImages


def write_report(run_dir: Path) -> Path:
    """Write ``report.html`` and ``gallery/`` into the folder of a finished run; returns the report's path.

    Both depend on the run's tables, `run.json`, transforms and textures alone: the same ones give the same bytes; the
    gallery shows no times, so equal runs have equal galleries. A transform whose file is gone or damaged is listed as
    such instead of stopping the report. Raises `pipeline.report.run.ReportError` (a FileNotFoundError) if a table is
    missing. Ours.
    """
    run = read_run(run_dir)
    puzzles = {puzzle.rank: puzzle for puzzle in run.puzzles}
    lost: list[Rejection] = []
    rows: list[TransformRow] = []
    inputs: dict[int, tuple[Markup, Markup]] = {}
    temporary = new_place(run_dir)
    temporary.mkdir()
    for before, now, after in _between(_readable(run_dir, run.constructed, lost)):
        row = now.row
        neighbours = [None if neighbour is None else neighbour.row for neighbour in (before, after)]
        puzzle = puzzles.get(row.rank)
        shown = card(row, now.transform, now.images)
        _write(
            temporary / row.page,
            transform_page(shown, now.transform, puzzle, _files(run_dir, puzzle), *neighbours, address=run.address),
        )
        _write(temporary / row.thumb, thumb(now.transform, now.images))
        if row.swing:
            _write(temporary / row.swing, swing(now.transform, now.images))
        (temporary / row.preview).write_bytes(preview(now.transform, now.images))
        rows.append(row)
        inputs[row.rank] = silhouettes(now.transform)
    printed = frozenset(rank for rank, puzzle in puzzles.items() if puzzle.folder)
    classes = CLASSES if len(run.classes) >= LEAST else ""
    _write(temporary / gallery.INDEX, gallery.index(run.name, rows, printed, classes))
    if classes:
        _write(temporary / classes, classes_page(run, rows))
    for name, text in gallery.files().items():
        _write(temporary / name, text)
    replace_folder(temporary, run_dir / GALLERY)
    target = run_dir / REPORT
    write_atomically(target, page(run, rows, inputs, lost).encode())
    return target


def _readable(run_dir: Path, rows: Iterable[TransformRow], lost: list[Rejection]) -> Iterator[_Drawn]:
    """The transforms whose files can be read; the others are added to ``lost``."""
    for row in rows:
        try:
            text = (run_dir / row.file).read_text(encoding="utf-8", errors="replace")
            transform = from_json(text, row.file)
        except FileNotFoundError:
            lost.append(Rejection(row, "unreadable", f"{row.file} is gone; run again to restore it"))
        except FormatError as error:
            lost.append(Rejection(row, "unreadable", str(error)))
        else:
            yield _Drawn(row, transform, read_textures(run_dir, row.file, len(transform)))


def _files(run_dir: Path, puzzle: PuzzleRow | None) -> list[str]:
    """Names of the files of a puzzle, in order, relative to its folder."""
    if puzzle is None or not puzzle.folder:
        return []
    folder = run_dir / puzzle.folder
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())


def _between(drawn: Iterable[_Drawn]) -> Iterator[tuple[_Drawn | None, _Drawn, _Drawn | None]]:
    """Each transform with the previous and the next one; at most three are in memory."""
    before: _Drawn | None = None
    now: _Drawn | None = None
    for after in drawn:
        if now is not None:
            yield before, now, after
        before, now = now, after
    if now is not None:
        yield before, now, None


def _write(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8", newline="\n")

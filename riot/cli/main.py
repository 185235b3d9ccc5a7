"""The command line: `riot make A B -o DIR`, `riot trunks A B`, `riot show FILE.riot`, `riot print FILE.riot -o DIR`,
`riot slices MODEL --into A,B -o DIR`."""

from __future__ import annotations

import argparse
import errno
import math
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from rich.console import Console
from rich.table import Table

from riot.cli.print_puzzle import add_print
from riot.cli.size_options import name_options
from riot.cli.slices import add_slices
from riot.construction.pins import load_pins
from riot.construction.plan import ConstructionPlan
from riot.construction.plan_transform import construct_plan
from riot.construction.trunk_choice import alternatives, construct
from riot.draw import texture  # lazy: what paints takes a second to import
from riot.draw.animate import animate_svg
from riot.draw.figure import draw_transform
from riot.draw.film import film_writer, write_film
from riot.draw.piece_image import NO_IMAGES, PieceImages
from riot.draw.strip import draw_strip
from riot.draw.texture.names import SIDES, Side
from riot.errors import RiotError, TrunkError
from riot.geometry.shape import Shape
from riot.geometry.silhouette import read
from riot.kernels.warm import warm_all
from riot.motion.planner import motion_of, with_motion
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
from riot.transform.deformation import change_ratio, measure_deformation
from riot.transform.fidelity import bending_ratio, direction_error
from riot.transform.history import History
from riot.transform.motion import Motion
from riot.transform.provenance import describe_history, file_digest, record_history
from riot.transform.riot_file import load, save
from riot.transform.transform import Transform

if TYPE_CHECKING:
    Commands = argparse._SubParsersAction[argparse.ArgumentParser]


def main(arguments: Sequence[str] | None = None, more: Sequence[Callable[[Commands], None]] = ()) -> int:
    """Run one command; returns its exit code (0), or 2 with a message on standard error if it could not be done.

    Each of ``more`` adds a command, a parser with ``run`` among its defaults: a function of what was chosen, which
    returns the exit code.
    """
    chosen = _parser(more).parse_args(arguments)
    try:
        code: int = chosen.run(chosen)
    except RiotError as error:
        text = name_options(str(error)) if chosen.command == "print" else str(error)
        print(f"riot: {text}", file=sys.stderr)
        return 2
    except OSError as error:
        message = f"{error.filename}: {error.strerror}; check the path" if error.filename and error.strerror else error
        print(f"riot: {message}", file=sys.stderr)
        return 2
    return code


@dataclass(frozen=True)
class Wishes:
    """What else to do than the usual: suffixes of films (.gif, .mp4), the trunk pair by rank, pins, the method."""

    films: tuple[str, ...] = ()
    rank: int | None = None
    pins: Path | None = None
    method: Literal["exact", "laplacian"] = "exact"
    pictures: Mapping[Side, Path] | None = None
    """Colour pictures of P and Q, of the same size as the inputs: what the pieces show."""


def make(path_a: Path, path_b: Path, folder: Path, wishes: Wishes | None = None) -> None:
    """Construct the transform of two silhouettes and write it to ``folder``: .riot, pictures, animation.

    Raises `riot.errors.TrunkError` if there is no trunk pair of the rank that is wished for.
    """
    wishes = wishes or Wishes()
    films = wishes.films
    if ".mp4" in films:
        film_writer()  # before the long work: it raises if there is none
    a, b = _inputs(path_a, path_b)
    pins = None if wishes.pins is None else load_pins(wishes.pins, a, b)
    if folder.exists() and not folder.is_dir():
        raise NotADirectoryError(errno.ENOTDIR, "a file, where results need a folder", str(folder))
    folder.mkdir(parents=True, exist_ok=True)
    warm_all(lambda text: print(text, file=sys.stderr))
    print(f"QCRS {qcrs(a, b).score:.3f}, CRS {crs(a, b).score:.3f}")
    parameters = ConstructParameters(method=wishes.method)
    if wishes.rank is None:
        transform = construct(a, b, parameters=parameters, pins=pins)
    else:
        transform = construct_plan(_ranked(alternatives(a, b), wishes.rank), parameters, pins)
    if certify(transform).passed:
        transform = with_motion(transform)
    transform = replace(transform, history=_history(path_a, path_b, parameters, wishes))
    show(transform)
    images = _piece_images(transform, wishes.pictures, {"p": path_a, "q": path_b})
    for path in _written(transform, folder / f"{path_a.stem}--{path_b.stem}", films, images):
        print(path)


def list_trunks(path_a: Path, path_b: Path) -> None:
    """Print the trunk pairs of two silhouettes that `make` can be told to use, by rank."""
    a, b = _inputs(path_a, path_b)
    warm_all(lambda text: print(text, file=sys.stderr))
    table = Table(
        "rank", "pieces", f"IoU {a.name} ≤", f"IoU {b.name} ≤", title="Refined trunk pairs", title_justify="left"
    )
    for rank, plan in enumerate(alternatives(a, b), start=1):
        table.add_row(str(rank), str(len(plan.trunk_p)), f"{plan.bound_p:.4f}", f"{plan.bound_q:.4f}")
    Console().print(table)


def _history(path_a: Path, path_b: Path, parameters: ConstructParameters, wishes: Wishes) -> History:
    pins = None if wishes.pins is None else file_digest(wishes.pins)
    steps: dict[str, dict[str, Any]] = {
        "ingest": asdict(ShapeParameters()),
        "trunks": asdict(TrunkParameters()),
        "crs": asdict(CrsParameters()),
        "refine": asdict(RefineParameters()),
        "construct": {**asdict(parameters), "rank": wishes.rank, "pins": pins},
        "motion": asdict(MotionParameters()),
    }
    return record_history("riot make", (path_a, path_b), steps)


def _ranked(plans: Sequence[ConstructionPlan], rank: int) -> ConstructionPlan:
    if not 1 <= rank <= len(plans):
        raise TrunkError(f"there is no trunk pair of rank {rank}: there are {len(plans)}; `riot trunks A B` lists them")
    return plans[rank - 1]


def show(transform: Transform) -> None:
    """Print the numbers of a transform."""
    deformation, certificate = measure_deformation(transform), certify(transform)
    title = f"{transform.p.name} ⇄ {transform.q.name}, {len(transform)} pieces"
    table = Table("", transform.p.name, transform.q.name, title=title, title_justify="left")
    for words, source, field, form in (
        ("IoU with the input", deformation, "iou", ".4f"),
        ("bound of the IoU", transform, "bound", ".4f"),
        ("Hausdorff distance / L_c", deformation, "hausdorff", ".4f"),
        ("mean distance / L_c", deformation, "mean_distance", ".4f"),
    ):
        table.add_row(words, *(format(getattr(source, f"{field}_{side}"), form) for side in "pq"))
    outlines = ((transform.outline_p(), transform.p.points), (transform.outline_q(), transform.q.points))
    changes = [change_ratio(getattr(deformation, f"iou_{side}"), getattr(transform, f"bound_{side}")) for side in "pq"]
    table.add_row("change / least change", *("–" if math.isnan(change) else f"{change:.3f}" for change in changes))
    table.add_row("bending / input's", *(f"{bending_ratio(*both):.3f}" for both in outlines))
    table.add_row("directions off, degrees", *(f"{math.degrees(direction_error(*both)):.2f}" for both in outlines))
    for words, field in (("overlap", "overlap"), ("gaps", "gap"), ("hinges apart", "hinge")):
        table.add_row(words, *(f"{getattr(side, field):.1e}" for side in (certificate.p, certificate.q)))
    Console().print(table)
    print("certificate: passed" if certificate.passed else f"certificate: failed ({certificate.failure})")
    if not certificate.passed:
        return
    motion = motion_of(transform)
    print(f"motion: {motion.words} ({motion.search}, open at hinge {_hinges(motion)})")


def _hinges(motion: Motion) -> str:
    opened = str(motion.open_hinge)
    return opened if motion.flat else f"{opened}, lifting at {', '.join(map(str, motion.lifted))}"


def _piece_images(
    transform: Transform, pictures: Mapping[Side, Path] | None, masks: Mapping[Side, Path]
) -> PieceImages:
    if not pictures:
        return NO_IMAGES
    textures = texture.paint.find_textures(transform, pictures, masks)
    return texture.sample.piece_images(transform, textures)


def _written(transform: Transform, stem: Path, films: Sequence[str], images: PieceImages) -> Iterator[Path]:
    """Write the files of a transform, ``stem`` and a suffix each; yields each path when it is written."""

    def swing(path: Path) -> None:
        path.write_text(animate_svg(transform, images), encoding="utf-8")

    kinds: list[tuple[str, Callable[[Path], None]]] = [
        (".riot", lambda path: save(transform, path)),
        (".svg", lambda path: draw_transform(transform, path, images)),
        (".png", lambda path: draw_transform(transform, path, images)),
        (".strip.svg", lambda path: draw_strip(transform, path, images)),
        (".strip.png", lambda path: draw_strip(transform, path, images)),
        (".swing.svg", swing),
        *((film, lambda path: write_film(transform, path, images=images)) for film in films),
    ]
    for suffix, write in kinds:
        path = stem.with_name(f"{stem.name}{suffix}")
        write(path)
        yield path


def _inputs(path_a: Path, path_b: Path) -> tuple[Shape, Shape]:
    return _named(path_a, path_b), _named(path_b, path_a)


def _named(path: Path, other: Path) -> Shape:
    """The shape in a file, named so that the two inputs can be told apart."""
    name = path.name if path.stem == other.stem else path.stem
    return read(path).renamed(name)


def _make(chosen: argparse.Namespace) -> int:
    films = tuple(f".{kind}" for kind in ("gif", "mp4") if getattr(chosen, kind))
    pictures = {side: path for side in SIDES if (path := getattr(chosen, f"texture_{side}"))}
    make(chosen.a, chosen.b, chosen.output, Wishes(films, chosen.rank, chosen.pins, chosen.method, pictures))
    return 0


def _trunks(chosen: argparse.Namespace) -> int:
    list_trunks(chosen.a, chosen.b)
    return 0


def _show(chosen: argparse.Namespace) -> int:
    transform = load(chosen.file)
    if not chosen.history:
        show(transform)
    elif transform.history is None:
        print(f"{chosen.file} tells no history: it was written by an earlier version, or by hand")
    else:
        print("\n".join(describe_history(transform.history)))
    return 0


def _parser(more: Sequence[Callable[[Commands], None]]) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="riot", description="Reversible shape transforms, certified.")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    make_parser = commands.add_parser("make", help="turn one silhouette inside out into another")
    trunks_parser = commands.add_parser("trunks", help="list the trunk pairs that make can be told to use")
    for of_two_files in (make_parser, trunks_parser):
        of_two_files.add_argument(
            "a", type=Path, metavar="A", help="a picture (PNG, GIF, BMP, TIFF, JPEG) or an SVG file"
        )
        of_two_files.add_argument("b", type=Path, metavar="B", help="another one")
    trunks_parser.set_defaults(run=_trunks)
    make_parser.add_argument("--rank", type=int, metavar="K", help="use the trunk pair of this rank of `riot trunks`")
    make_parser.add_argument(
        "--pins", type=Path, metavar="FILE", help="keep or redraw stretches of the outlines (JSON)"
    )
    make_parser.add_argument(
        "--method", choices=("exact", "laplacian"), default="exact", help="laplacian: the paper's, not exact"
    )
    make_parser.add_argument("-o", "--output", type=Path, required=True, metavar="DIR", help="where results go")
    make_parser.add_argument("--gif", action="store_true", help="film the motion as an animated GIF too")
    make_parser.add_argument("--mp4", action="store_true", help="film it as an MP4 too (needs the extra 'film')")
    for side, name in zip(SIDES, "AB", strict=True):
        make_parser.add_argument(
            f"--texture-{side}",
            type=Path,
            metavar="PICTURE",
            help=f"show {name}'s colours on the pieces, from a picture of its size ({name} itself, if it has colours)",
        )
    make_parser.set_defaults(run=_make)
    show_parser = commands.add_parser("show", help="print the numbers of a .riot file")
    show_parser.add_argument("file", type=Path, metavar="FILE.riot")
    show_parser.add_argument(
        "--history", action="store_true", help="print pictures, parameters, code and libraries that made it instead"
    )
    show_parser.set_defaults(run=_show)
    for add in (add_print, add_slices, *more):
        add(commands)
    return parser


if __name__ == "__main__":
    sys.exit(main())

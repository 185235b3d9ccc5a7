"""The command line: `riot make A B -o DIR`, `riot show FILE.riot`."""

from __future__ import annotations

import argparse
import errno
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console
from rich.table import Table

from riot.construct import construct
from riot.cross import crs
from riot.draw import animate_svg, draw_strip, write_film
from riot.draw.film import film_writer
from riot.errors import RiotError
from riot.kernels.warm import warm_all
from riot.motion import Motion
from riot.quick import qcrs
from riot.shape import Shape
from riot.silhouette import read
from riot.transform import Transform

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
        print(f"riot: {error}", file=sys.stderr)
        return 2
    except OSError as error:
        said = f"{error.filename}: {error.strerror}; check the path" if error.filename and error.strerror else error
        print(f"riot: {said}", file=sys.stderr)
        return 2
    return code


def make(path_a: Path, path_b: Path, folder: Path, films: Sequence[str] = ()) -> None:
    """Construct the transform of two silhouettes and write it to ``folder``: .riot, pictures, animation.

    ``films`` are suffixes (.gif, .mp4) of films to write as well.
    """
    if ".mp4" in films:
        film_writer()  # before the long work: it raises if there is none
    a, b = (_named(path, other) for path, other in ((path_a, path_b), (path_b, path_a)))
    if folder.exists() and not folder.is_dir():
        raise NotADirectoryError(errno.ENOTDIR, "a file, where results need a folder", str(folder))
    folder.mkdir(parents=True, exist_ok=True)
    warm_all(lambda text: print(text, file=sys.stderr))
    print(f"QCRS {qcrs(a, b).score:.3f}, CRS {crs(a, b).score:.3f}")
    transform = construct(a, b).planned()
    show(transform)
    for path in _written(transform, folder / f"{path_a.stem}--{path_b.stem}", films):
        print(path)


def show(transform: Transform) -> None:
    """Print the numbers of a transform."""
    deformation, certificate = transform.deformation(), transform.certificate()
    title = f"{transform.p.name} ⇄ {transform.q.name}, {len(transform)} pieces"
    table = Table("", transform.p.name, transform.q.name, title=title, title_justify="left")
    for words, source, field, form in (
        ("IoU with the input", deformation, "iou", ".4f"),
        ("bound of the IoU", transform, "bound", ".4f"),
        ("Hausdorff distance / L_c", deformation, "hausdorff", ".4f"),
        ("mean distance / L_c", deformation, "mean_distance", ".4f"),
    ):
        table.add_row(words, *(format(getattr(source, f"{field}_{side}"), form) for side in "pq"))
    for words, field in (("overlap", "overlap"), ("gaps", "gap"), ("hinges apart", "hinge")):
        table.add_row(words, *(f"{getattr(side, field):.1e}" for side in (certificate.p, certificate.q)))
    Console().print(table)
    print("certificate: passed" if certificate.passed else f"certificate: failed ({certificate.failure})")
    motion = transform.motion()
    print(f"motion: {motion.words} ({motion.search}, open at hinge {_hinges(motion)})")


def _hinges(motion: Motion) -> str:
    said = str(motion.open_hinge)
    return said if motion.flat else f"{said}, lifting at {', '.join(map(str, motion.lifted))}"


def _written(transform: Transform, stem: Path, films: Sequence[str]) -> Iterator[Path]:
    """Write the files of a transform, ``stem`` and a suffix each; yields each path when it is written."""

    def save(path: Path) -> None:
        path.write_text(animate_svg(transform), encoding="utf-8")

    kinds: list[tuple[str, Callable[[Path], None]]] = [
        (".riot", transform.save),
        (".svg", transform.draw),
        (".png", transform.draw),
        (".strip.svg", lambda path: draw_strip(transform, path)),
        (".strip.png", lambda path: draw_strip(transform, path)),
        (".swing.svg", save),
        *((film, lambda path: write_film(transform, path)) for film in films),
    ]
    for suffix, write in kinds:
        path = stem.with_name(f"{stem.name}{suffix}")
        write(path)
        yield path


def _named(path: Path, other: Path) -> Shape:
    """The shape in a file, named so that the two inputs can be told apart."""
    name = path.name if path.stem == other.stem else path.stem
    return read(path).renamed(name)


def _make(chosen: argparse.Namespace) -> int:
    make(chosen.a, chosen.b, chosen.output, [f".{kind}" for kind in ("gif", "mp4") if getattr(chosen, kind)])
    return 0


def _show(chosen: argparse.Namespace) -> int:
    show(Transform.load(chosen.file))
    return 0


def _parser(more: Sequence[Callable[[Commands], None]]) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="riot", description="Reversible shape transforms, certified.")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    make_parser = commands.add_parser("make", help="turn one silhouette inside out into another")
    make_parser.add_argument("a", type=Path, metavar="A", help="a picture (PNG, GIF, BMP, TIFF, JPEG) or an SVG file")
    make_parser.add_argument("b", type=Path, metavar="B", help="another one")
    make_parser.add_argument("-o", "--output", type=Path, required=True, metavar="DIR", help="where results go")
    make_parser.add_argument("--gif", action="store_true", help="film the motion as an animated GIF too")
    make_parser.add_argument("--mp4", action="store_true", help="film it as an MP4 too (needs the extra 'film')")
    make_parser.set_defaults(run=_make)
    show_parser = commands.add_parser("show", help="print the numbers of a .riot file")
    show_parser.add_argument("file", type=Path, metavar="FILE.riot")
    show_parser.set_defaults(run=_show)
    for add in more:
        add(commands)
    return parser


if __name__ == "__main__":
    sys.exit(main())

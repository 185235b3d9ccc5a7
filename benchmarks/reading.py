"""How silhouettes are read: by which way, how long it takes, and what differs from another reading.

``python benchmarks/reading.py --root PICTURES --save new.npz`` reads a folder and says how many outlines were taken
from paths, how many rendered, how many are doubtful or refused, and processor time a file. ``--against old.npz``
compares with what another version of the project saved. ``--fine`` also says how far the rendered outlines of plain
drawings are from those of their paths.
"""

from __future__ import annotations

import argparse
import resource
from collections import Counter
from pathlib import Path
from unittest import mock

import numpy as np
import shapely

from riot.errors import SilhouetteError
from riot.geometry import svg_outline
from riot.geometry.shape import Shape
from riot.geometry.silhouette import read
from riot.types import FloatArray
from riot.units import L_C

SUFFIXES = {".png", ".gif", ".bmp", ".tif", ".tiff", ".jpg", ".jpeg", ".webp", ".avif", ".svg", ".svgz"}
ALIKE = 1e-3
"""Two readings differ if their outlines are farther apart, in ``L_c``."""


def main() -> None:
    """Read, tell, save, compare."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--root", type=Path, required=True, help="folder of pictures and drawings")
    parser.add_argument("--every", type=int, default=1, help="read every n-th file")
    parser.add_argument("--save", type=Path, help="write the outlines to this .npz file")
    parser.add_argument("--against", type=Path, help="compare with the outlines of this .npz file")
    parser.add_argument("--fine", action="store_true", help="compare rendered outlines with those of paths")
    arguments = parser.parse_args()
    paths = sorted(path for path in arguments.root.rglob("*") if path.suffix.lower() in SUFFIXES)[:: arguments.every]
    if not paths:
        parser.error(f"{arguments.root}: no pictures")
    outlines = read_all(paths, arguments.root)
    if arguments.save:
        np.savez_compressed(arguments.save, allow_pickle=False, **outlines)
    if arguments.against:
        with np.load(arguments.against) as other:
            compare(outlines, {name: other[name] for name in other.files})
    if arguments.fine:
        compare_with_paths(paths)


def read_all(paths: list[Path], root: Path) -> dict[str, FloatArray]:
    """Read files; outlines (m, 2) of those that are shapes, by their paths below ``root``."""
    outlines: dict[str, FloatArray] = {}
    ways: Counter[str] = Counter()
    seconds = []
    drawn = svg_outline.outline

    def counted(*given: object) -> svg_outline.DrawnOutline:
        outline = drawn(*given)  # type: ignore[arg-type]
        ways["rendered" if outline.rendered else "paths"] += 1
        return outline

    try_to_read(paths[0])  # kernels are loaded
    with mock.patch.object(svg_outline, "outline", counted):
        for path in paths:
            before = processor_time()
            shape = try_to_read(path)
            seconds.append(processor_time() - before)
            if isinstance(shape, SilhouetteError):
                ways[f"refused: {shape.reason}"] += 1
                print(shape)
                continue
            outlines[path.relative_to(root).as_posix()] = shape.points
            if shape.quality is not None and shape.quality.doubtful:
                ways["doubtful"] += 1
                print(f"{path}: {'; '.join(shape.quality.doubts)}")
    print(f"{len(paths)} files: " + ", ".join(f"{count} {way}" for way, count in sorted(ways.items())))
    quantiles = np.quantile(seconds, [0.5, 0.95, 1.0]) * 1e3
    print("processor ms a file: median {:.1f}, 95 % {:.1f}, most {:.1f}".format(*quantiles))
    return outlines


def try_to_read(path: Path) -> Shape | SilhouetteError:
    """The shape, or why there is none."""
    try:
        return read(path)
    except SilhouetteError as error:
        return error


def processor_time() -> float:
    """Seconds of this process and of those that it started."""
    usages = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(usage.ru_utime + usage.ru_stime for usage in usages)


def compare(new: dict[str, FloatArray], old: dict[str, FloatArray]) -> None:
    """Tell what only one reading has, and whose outlines differ."""
    for name in sorted(new.keys() ^ old.keys()):
        print(f"{name}: only in the {'new' if name in new else 'old'} reading")
    common = sorted(new.keys() & old.keys())
    distances = {name: apart(new[name], old[name]) for name in common}
    for name in sorted(common, key=lambda name: -distances[name]):
        if distances[name] > ALIKE:
            print(f"{name}: {distances[name]:.2e} L_c apart")
    print(f"{sum(d > ALIKE for d in distances.values())} of {len(common)} differ by more than {ALIKE} L_c; "
          f"most {max(distances.values(), default=0.0):.2e}")  # fmt: skip


def compare_with_paths(paths: list[Path]) -> None:
    """Tell how far the rendered outlines of plain drawings are from those of their paths."""
    errors = []
    for path in paths:
        if not svg_outline.looks_like_svg(path) or isinstance(try_to_read(path), SilhouetteError):
            continue
        exact = svg_outline.outline(path)
        if exact.rendered:
            continue
        with mock.patch.object(svg_outline, "is_plain", lambda _: False):
            pixels = svg_outline.outline(path)
        region = shapely.Polygon(exact.points)
        unit = L_C * np.sqrt(region.area)
        errors.append(shapely.distance(region.exterior, shapely.points(pixels.points)).mean() / unit)
    if errors:
        print("rendered outlines from those of paths, mean along each, in L_c: median {:.1e}, 95 % {:.1e}, most {:.1e}"
              .format(*np.quantile(errors, [0.5, 0.95, 1.0])))  # fmt: skip


def apart(first: FloatArray, second: FloatArray) -> float:
    """Hausdorff distance of two outlines of unit area, in ``L_c``."""
    return float(shapely.hausdorff_distance(shapely.LinearRing(first), shapely.LinearRing(second))) / L_C


if __name__ == "__main__":
    main()

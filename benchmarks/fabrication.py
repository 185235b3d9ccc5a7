"""Puzzles of transforms: designed, certified, written, and read back by other programs; a row a puzzle.

    python benchmarks/fabrication.py                         Dudeney's triangle and six exact pairs
    python benchmarks/fabrication.py RUN/transforms --top 20  the first .riot files of a folder, by name
    python benchmarks/fabrication.py RUN/transforms --every 19 --pivot screw
    python benchmarks/fabrication.py RUN/transforms --fix     the same, mended where the size that is asked for fails

Read back are the solids of every STL and 3MF file (trimesh) and the areas of the laser's outlines in SVG and DXF (a
plain parser, ezdxf). ``file error`` is the greatest relative difference of a volume or area from the design's; exit
code 1 if one is above `AGREED` or a solid is not closed. A puzzle that cannot be made as asked is a row with the reason
and no error. Seconds are CPU time of one core for design, solids and certificate; files are written besides.
"""

from __future__ import annotations

import pipeline.runtime.threads  # noqa: F401  (before anything that loads a numeric library)

# ruff: isort: split
import argparse
import json
import re
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from xml.etree import ElementTree

import ezdxf
import numpy as np
import shapely
import trimesh
from rich.console import Console
from rich.table import Table

from riot.fabricate import BuiltPuzzle, FabricationError, FabricationParameters, build, fix
from riot.fabricate.export.flat import write_flat_files
from riot.fabricate.export.flat_parts import flat_parts
from riot.fabricate.export.solids import write_puzzle
from riot.groundtruth.pairs import dudeney, exact_pair, exact_transform
from riot.kernels.warm import warm_all
from riot.parameters.fabrication import PIVOTS
from riot.transform.riot_file import load
from riot.transform.transform import Transform

AGREED = 1e-6
"""Greatest relative difference of what is read back."""

EXACT = ((3, 1), (4, 2), (4, 3), (5, 5), (6, 1), (6, 2))
"""Pieces and seeds of the exact pairs."""


@dataclass(frozen=True)
class Figures:
    """One puzzle; lengths in mm, volumes in cm³ (all pieces) and mm³ (in common), NaN where there is none.

    ``hinges`` is the greatest share of a piece that its hinges take, ``overhang`` the greatest lean of a layer over the
    one below in degrees, ``bridge`` the longest bridge, ``press`` the least interference of a pin. ``gap`` is the least
    found among samples of the motion, ``proven`` what is proven at every moment, ``placed`` the least in space between
    pieces that are printed in place. ``solids`` is the greatest number of
    connected components of one part.
    """

    name: str
    status: str
    pieces: int
    size: float = float("nan")
    solids: int = 0
    volume: float = float("nan")
    hinges: float = float("nan")
    overhang: float = float("nan")
    bridge: float = float("nan")
    press: float = float("nan")
    wall: float = float("nan")
    gap: float = float("nan")
    proven: float = float("nan")
    overlap: float = float("nan")
    placed: float = float("nan")
    telescopes: int = 0
    seconds: float = float("nan")
    file_error: float = float("nan")
    message: str = ""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run, print the table, write JSON if asked; 1 if a file does not hold what was designed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, nargs="?", help="a folder of .riot files")
    parser.add_argument("--top", type=int, default=20, help="so many of them (default 20)")
    parser.add_argument("--every", type=int, default=1, help="every so many-th of the folder's files (default 1)")
    parser.add_argument("--pivot", choices=tuple(PIVOTS), default="printed", help="what hinges turn on")
    parser.add_argument("--size", type=float, default=FabricationParameters().size_mm, help="long side, mm")
    parser.add_argument("--fix", action="store_true", help="mend what fails, as riot print --fix does")
    parser.add_argument("--json", type=Path, help="write the figures to this file too")
    chosen = parser.parse_args(arguments)
    paths = [] if chosen.folder is None else sorted(chosen.folder.glob("*.riot"))[:: chosen.every][: chosen.top]
    if chosen.folder is not None and not paths:
        parser.error(f"no .riot files in {chosen.folder}")
    warm_all(lambda text: print(text, file=sys.stderr))
    given = [(path.stem, load(path)) for path in paths]
    if not given:
        given = [(f"exact pair {n}, {seed}", exact_transform(exact_pair(n, seed))) for n, seed in EXACT]
    given.insert(0, ("Dudeney", exact_transform(dudeney())))
    parameters = FabricationParameters(**{**PIVOTS[chosen.pivot], "size_mm": chosen.size})
    rows = [measured(name, transform, parameters, mend=chosen.fix) for name, transform in given]
    show(rows)
    if chosen.json:
        chosen.json.write_text(json.dumps([asdict(row) for row in rows], indent=1) + "\n", encoding="utf-8")
    wrong = [row.name for row in rows if row.file_error > AGREED]
    if wrong:
        print(f"files do not hold what was designed: {', '.join(wrong)}", file=sys.stderr)
    return 1 if wrong else 0


def measured(name: str, transform: Transform, parameters: FabricationParameters, *, mend: bool) -> Figures:
    """Figures of one transform's puzzle."""
    start = time.process_time()
    try:
        puzzle = (fix if mend else build)(transform, parameters)
    except FabricationError as error:
        spent = time.process_time() - start
        return Figures(name, error.reason, len(transform), parameters.size_mm, seconds=spent, message=str(error))
    spent, certificate = time.process_time() - start, puzzle.certificate
    return Figures(
        name,
        "certified" if certificate.passed else "failed",
        len(transform),
        puzzle.design.parameters.size_mm,
        max(check.components for check in certificate.parts),
        sum(check.volume for check in certificate.parts if check.name.startswith("piece")) / 1000.0,
        certificate.hinge_share,
        certificate.overhang,
        certificate.bridge,
        min(
            (check.interference for check in certificate.hinges if check.interference is not None), default=float("nan")
        ),
        certificate.wall,
        certificate.motion.gap,
        certificate.motion.floor if certificate.motion.proven else float("nan"),
        certificate.motion.overlap,
        float("nan") if certificate.placement is None else certificate.placement.gap,
        len(puzzle.design.motion.lifted),
        spent,
        file_error(puzzle) if certificate.passed else float("nan"),
        "; ".join(certificate.failures or puzzle.changes),
    )


def file_error(puzzle: BuiltPuzzle) -> float:
    """The greatest relative difference of a volume or area read back; infinite if a solid is not closed."""

    def flat_files(where: Path) -> None:
        write_flat_files(puzzle.design, where)

    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary) / "puzzle"
        write_puzzle(
            puzzle.design,
            puzzle.parts,
            puzzle.certificate,
            folder,
            [flat_files],
        )
        volumes = {solid_part.name: solid_part.volume for solid_part in puzzle.parts}
        volumes["chain"] = sum(volumes[piece.name] for piece in puzzle.design.pieces)
        meshes = [(path.stem, trimesh.load_mesh(path)) for path in sorted(folder.glob("*.stl"))]
        for plate in sorted(folder.glob("*.3mf")):
            meshes += trimesh.load_scene(plate).geometry.items()
        solids = [abs(mesh.volume / volumes[name] - 1.0) if mesh.is_watertight else np.inf for name, mesh in meshes]
        outlines = sorted(
            flat_part.region.area
            for flat_part in flat_parts(puzzle.design, "outlines")
            for _ in range(flat_part.copies)
        )
        flat = [
            abs(area / expected - 1.0)
            for areas in (_svg_areas(folder), _dxf_areas(folder))
            for area, expected in zip(sorted(areas), outlines, strict=True)
        ]
        return float(max(solids + flat))


def _svg_areas(folder: Path) -> list[float]:
    """Areas of the outlines on all sheets, mm²."""
    groups = [
        group
        for sheet in _sheets(folder, "svg")
        for group in ElementTree.parse(sheet).getroot().iter("{http://www.w3.org/2000/svg}g")
        if group.attrib["id"] == "cut"
    ]
    paths = [re.findall(r"-?[\d.]+", path.attrib["d"]) for group in groups for path in group]
    return [float(shapely.Polygon(np.array(path, dtype=np.float64).reshape(-1, 2)).area) for path in paths]


def _dxf_areas(folder: Path) -> list[float]:
    """Areas of the outlines on all sheets, mm²."""
    drawn = [ezdxf.readfile(sheet).modelspace() for sheet in _sheets(folder, "dxf")]  # type: ignore[attr-defined]
    paths = [path for space in drawn for path in space if path.dxf.layer == "CUT"]
    return [float(shapely.Polygon(np.array(path.get_points("xy"))).area) for path in paths]  # type: ignore[attr-defined]


def _sheets(folder: Path, suffix: str) -> list[Path]:
    return [path for path in sorted(folder.glob(f"laser-outlines*.{suffix}")) if "-kerf" not in path.name]


def show(rows: Sequence[Figures]) -> None:
    """Print a row a puzzle, and how many are certified."""
    table = Table(title="Puzzles: mm, cm³ in all pieces, mm³ in common", title_justify="left")
    numeric = [field.name for field in fields(Figures) if field.name not in ("name", "status", "message")]
    for heading in ("name", "status", *numeric):
        table.add_column(heading.replace("_", " "), justify="right" if heading in numeric else "left")
    for row in rows:
        cells = [getattr(row, name) for name in numeric]
        table.add_row(row.name, row.status, *("" if cell != cell else f"{cell:.3g}" for cell in cells))
    console = Console(width=None if sys.stdout.isatty() else 160)
    console.print(table)
    for row in rows:
        if row.message:
            console.print(f"{row.name}: {row.message}", highlight=False, markup=False, soft_wrap=True)
    certified = sum(row.status == "certified" for row in rows)
    mean = float(np.mean([row.seconds for row in rows]))
    console.print(f"{certified} of {len(rows)} certified; mean {mean:.2f} s", highlight=False)


if __name__ == "__main__":
    sys.exit(main())

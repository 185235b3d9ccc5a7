"""A solid read from an STL, 3MF or OBJ file, checked. trimesh reads it, manifold3d holds it. Ours."""

from __future__ import annotations

import importlib
import os
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from riot.errors import ModelError as ModelError
from riot.errors import needs_extra
from riot.slices.tuning import GREATEST_BYTES, GREATEST_COORDINATE_MM, GREATEST_TRIANGLES
from riot.types import FloatArray, IntArray

with needs_extra("print"):
    import manifold3d

SUFFIXES = (".stl", ".3mf", ".obj")


@dataclass(frozen=True, eq=False)
class Model:
    """A closed solid.

    Parameters
    ----------
    name : str
        The file's, without suffix.
    solid : manifold3d.Manifold
        In mm: files without a unit (STL, OBJ) are taken to be in mm.
    """

    name: str
    solid: manifold3d.Manifold

    @property
    def size(self) -> tuple[float, float, float]:
        """Of the box around it, mm."""
        box = self.solid.bounding_box()
        return box[3] - box[0], box[4] - box[1], box[5] - box[2]


def read_model(path: str | os.PathLike[str]) -> Model:
    """Read a solid, told by the suffix; all objects of a file together are one.

    A surface that is inside out as a whole is turned. Several closed parts may overlap.

    Raises
    ------
    ModelError
        ``unsupported`` (another suffix), ``too-large``, ``unreadable``, ``empty``, ``open`` (not watertight).
    riot.errors.MissingExtraError
        trimesh is not installed.
    OSError
        The file cannot be opened.
    """
    where = Path(path)
    if where.suffix.lower() not in SUFFIXES:
        raise ModelError(
            "unsupported", f"{where}: a solid is read from {', '.join(SUFFIXES)}; export it as one of these"
        )
    _check_size(where)
    points, triangles = _mesh(where)
    return Model(where.stem, _solid(points, triangles, str(where)))


def _check_size(path: Path) -> None:
    size = path.stat().st_size
    if size <= GREATEST_BYTES and path.suffix.lower() == ".3mf":
        try:
            with zipfile.ZipFile(path) as archive:
                size = sum(entry.file_size for entry in archive.infolist())
        except zipfile.BadZipFile as error:
            raise ModelError("unreadable", f"{path}: damaged, or no 3MF file ({error}); export it anew") from error
    if size > GREATEST_BYTES:
        raise ModelError(
            "too-large",
            f"{path}: holds {size >> 20} MiB, more than {GREATEST_BYTES >> 20}; export it with fewer triangles",
        )


def _mesh(path: Path) -> tuple[FloatArray, IntArray]:
    """(v, 3) points in mm and (f, 3) triangles; points in one place are one."""
    trimesh = _library()
    try:
        mesh = trimesh.load_mesh(path, skip_materials=True)
        if mesh.units is not None:
            mesh.convert_units("millimeter")
        mesh.merge_vertices(merge_tex=True, merge_norm=True)
        points, triangles = np.array(mesh.vertices, dtype=np.float64), np.array(mesh.faces, dtype=np.int64)
    except OSError:
        raise
    except ImportError as error:
        raise ModelError("unsupported", f"{path}: to read it takes the extra 'print': {error}") from error
    except Exception as error:  # the reader of a foreign format: its errors are of every kind
        reason = str(error).split("\n")[0]
        raise ModelError("unreadable", f"{path}: damaged, or no {path.suffix[1:].upper()} file ({reason})") from error
    if len(triangles) == 0:
        raise ModelError("empty", f"{path}: holds no triangles; export a solid, not points, curves or a sketch")
    if len(triangles) > GREATEST_TRIANGLES:
        raise ModelError(
            "too-large", f"{path}: holds {len(triangles):,} triangles, more than {GREATEST_TRIANGLES:,}; export fewer"
        )
    if not np.isfinite(points).all() or np.abs(points).max() > GREATEST_COORDINATE_MM:
        raise ModelError(
            "unreadable", f"{path}: holds coordinates that are no numbers or beyond {GREATEST_COORDINATE_MM:g} mm"
        )
    return points, triangles


def _solid(points: FloatArray, triangles: IntArray, where: str) -> manifold3d.Manifold:
    a, b, c = (points[triangles[:, k]] for k in range(3))
    if float((a * np.cross(b, c)).sum()) < 0.0:
        triangles = triangles[:, ::-1]
    solid = manifold3d.Manifold(
        manifold3d.Mesh64(np.ascontiguousarray(points), np.ascontiguousarray(triangles.astype(np.uint64)))
    )
    if solid.status() != manifold3d.Error.NoError:
        raise ModelError(
            "open",
            f"{where}: is not watertight ({_open_edges(triangles)} of its edges do not join two triangles that face "
            "the same way): mend it in a modelling program, or with a slicer's repair",
        )
    if solid.is_empty() or solid.volume() <= 0.0:
        raise ModelError("empty", f"{where}: encloses no volume; export a solid")
    return solid


def _open_edges(triangles: IntArray) -> int:
    """How many directed edges have no partner in the other direction, or more than one."""
    edges = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    size = int(triangles.max()) + 1
    there, back = edges[:, 0] * size + edges[:, 1], edges[:, 1] * size + edges[:, 0]
    edges_there, counts = np.unique(there, return_counts=True)
    return int((~np.isin(there, back)).sum() + (counts[np.isin(edges_there, back)] > 1).sum())


def _library() -> Any:
    with needs_extra("print"):
        return importlib.import_module("trimesh")

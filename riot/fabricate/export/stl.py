"""Solids as binary STL. Ours."""

from __future__ import annotations

import struct
from typing import Protocol

import numpy as np

from riot.types import FloatArray, IntArray


class Named(Protocol):
    """A solid with a name: a part, or a body of one."""

    @property
    def name(self) -> str: ...

    def mesh(self) -> tuple[FloatArray, IntArray]:
        """(v, 3) points in mm and (f, 3) triangles, counter-clockwise seen from outside."""
        ...


def stl_bytes(part: Named) -> bytes:
    """A solid as binary STL, mm; coordinates are rounded to 32 bits."""
    points, triangles = part.mesh()
    corners = points.astype("<f4")[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]).astype(np.float64)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    record = np.zeros(len(triangles), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    record["normal"] = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0.0)
    record["corners"] = corners
    header = f"riot {part.name}, mm".encode("ascii").ljust(80, b" ")
    return header + struct.pack("<I", len(triangles)) + record.tobytes()

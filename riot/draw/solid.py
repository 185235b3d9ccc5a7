"""Solids in the round, in a parallel view from above at a slant, by a depth buffer. Ours.

No window and no graphics library: every triangle is cut into rows of pixels, and of all that fall on a pixel the
nearest stays. Sums and products only, in a fixed order, so that a picture has the same bytes on any machine.
"""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageColor

from riot.draw.depth_buffer import nearest_triangles
from riot.draw.tuning import CREASE_COSINE, DARKEST_FACE, EDGE_SHADE, LIGHT_DIRECTION, SUPERSAMPLING
from riot.errors import needs_extra
from riot.types import BoolArray, FloatArray, IntArray

with needs_extra("print"):
    import manifold3d

ByteArray = npt.NDArray[np.uint8]


@dataclass(frozen=True)
class Eye:
    """Where the eye is: ``azimuth`` around the z-axis from the x-axis, ``elevation`` over the plane; radians."""

    azimuth: float
    elevation: float

    def view(self, points: FloatArray) -> FloatArray:
        """(v, 3) points as the eye has them: to the right, upwards, towards it.

        Examples
        --------
        >>> Eye(math.radians(-90.0), math.radians(90.0)).view(np.array([[1.0, 2.0, 3.0]])).round(9).tolist()
        [[1.0, 2.0, 3.0]]
        """
        x, y, z = points.T
        across, deep = -math.sin(self.azimuth), math.cos(self.azimuth)
        right = across * x + deep * y
        out = deep * x - across * y  # how far a point lies towards the eye on the plane
        up = z * math.cos(self.elevation) - out * math.sin(self.elevation)
        near = out * math.cos(self.elevation) + z * math.sin(self.elevation)
        return np.column_stack([right, up, near])

    def on_plane(self, right: FloatArray, up: FloatArray, z: float) -> FloatArray:
        """(k, 2) the points at height z that are seen so far to the right and upwards."""
        across, deep = -math.sin(self.azimuth), math.cos(self.azimuth)
        out = (z * math.cos(self.elevation) - up) / math.sin(self.elevation)
        return np.column_stack([across * right + deep * out, deep * right - across * out])


@dataclass(frozen=True, eq=False)
class Body:
    """A solid.

    Parameters
    ----------
    points : (v, 3) float64
        In mm.
    triangles : (f, 3) int64
        Counter-clockwise from outside.
    colour : "#rrggbb"
    top : callable, optional
        What the highest face shows instead: of (k, 2) points of the plane, which of them it covers, (k,) bool, and the
        colours of those, (m, 3) uint8; no light falls on it.
    """

    points: FloatArray
    triangles: IntArray
    colour: str
    top: Callable[[FloatArray], tuple[BoolArray, ByteArray]] | None = None


@dataclass(frozen=True, eq=False)
class View:
    """A picture, (rows, columns, 3), white where nothing is, its size in mm as seen, and its lower left corner."""

    pixels: ByteArray
    width: float
    height: float
    corner: tuple[float, float] = (0.0, 0.0)

    def pixel(self, points: FloatArray, eye: Eye) -> FloatArray:
        """(k, 2) columns and rows, from the upper left corner, of points (k, 3) in mm."""
        rows = self.pixels.shape[0]
        at: FloatArray = (eye.view(points)[:, :2] - self.corner) * [rows / self.height, -rows / self.height] + [0, rows]
        return at


def prisms(layers: Iterable[tuple[float, float, tuple[FloatArray, ...]]]) -> tuple[FloatArray, IntArray]:
    """Points and triangles of upright prisms: from z, to z, and the (k, 2) rings of the base, holes clockwise.

    Examples
    --------
    >>> points, triangles = prisms([(0.0, 2.0, (np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]),))])
    >>> points.shape, triangles.shape
    ((6, 3), (8, 3))
    """
    points, triangles, count = [], [], 0
    for low, high, rings in layers:
        solid = manifold3d.Manifold.extrude(manifold3d.CrossSection(list(rings)), high - low)
        corners, faces = mesh(solid)
        points.append(corners + np.array([0.0, 0.0, low]))
        triangles.append(faces + count)
        count += len(corners)
    return np.concatenate(points), np.concatenate(triangles)


def mesh(solid: manifold3d.Manifold) -> tuple[FloatArray, IntArray]:
    """Points (v, 3) and triangles (f, 3) of a solid."""
    raw = solid.to_mesh64()
    return np.array(raw.vert_properties[:, :3], dtype=np.float64), np.array(raw.tri_verts, dtype=np.int64)


def ribbon(start: FloatArray, end: FloatArray, width: float, eye: Eye, colour: str) -> Body:
    """A flat bar between two points (3,) that faces the eye."""
    towards = np.linalg.solve(eye.view(np.eye(3)).T, np.array([0.0, 0.0, 1.0]))
    side = np.cross(towards, end - start)
    side *= 0.5 * width / np.sqrt((side**2).sum())
    corners = np.array([start - side, end - side, end + side, start + side])
    return Body(corners, np.array([[0, 1, 2], [0, 2, 3]]), colour)


def render(bodies: Sequence[Body], mm_per_pixel: float, eye: Eye) -> View:
    """Draw some solids; edges between two of them, towards the background, and where a body turns sharply are dark."""
    step = mm_per_pixel / SUPERSAMPLING
    corners = [eye.view(body.points)[body.triangles] for body in bodies]
    all_corners = np.concatenate([triangles.reshape(-1, 3) for triangles in corners])
    low, high = all_corners.min(axis=0), all_corners.max(axis=0)
    # Two pixels of margin, for the edges.
    columns, rows = (SUPERSAMPLING * (math.ceil(length / mm_per_pixel) + 4) for length in (high - low)[:2].tolist())
    shift = np.array([low[0], low[1], 0.0]) - 2.0 * SUPERSAMPLING * step * np.array([1.0, 1.0, 0.0])
    triangle = nearest_triangles((np.concatenate(corners) - shift) / np.array([step, step, 1.0]), rows, columns)

    owners = np.repeat(np.arange(len(bodies)), [len(triangles) for triangles in corners])
    normals = _normals(np.concatenate(corners))
    bright = DARKEST_FACE + (1.0 - DARKEST_FACE) * np.clip((normals * np.array(LIGHT_DIRECTION)).sum(axis=1), 0.0, 1.0)
    colours = np.array([ImageColor.getrgb(body.colour)[:3] for body in bodies], dtype=np.float64)
    # One colour more, at the end, where index −1 finds it: the background.
    palette = np.append(np.rint(colours[owners] * bright[:, None]), [[255.0] * 3], axis=0).astype(np.uint8)
    image = palette[triangle]
    surface = np.append(owners, -1)[triangle]
    for number, body in enumerate(bodies):
        if body.top is not None:
            z = float(body.points[:, 2].max())
            flat = (body.points[body.triangles][:, :, 2] == z).all(axis=1)
            seen = np.flatnonzero(np.isin(triangle, np.flatnonzero(owners == number)[flat]))
            right, up = (seen % columns + 0.5) * step + shift[0], (seen // columns + 0.5) * step + shift[1]
            covered, pixels = body.top(eye.on_plane(right, up, z))
            image.reshape(-1, 3)[seen[covered]] = pixels
            surface.reshape(-1)[seen[covered]] = number + len(bodies)
    edges = _edges(surface, np.append(normals, [[0.0] * 3], axis=0), triangle)
    image[edges] = (EDGE_SHADE * image[edges]).astype(np.uint8)
    pixels = np.asarray(Image.fromarray(image[::-1]).reduce(SUPERSAMPLING))
    return View(pixels, columns * step, rows * step, (float(shift[0]), float(shift[1])))


def png_of_view(view: View, margin: int = 0) -> bytes:
    """A view as a PNG file, with a white margin of so many pixels."""
    rows, columns = view.pixels.shape[:2]
    picture = Image.new("RGB", (columns + 2 * margin, rows + 2 * margin), "white")
    picture.paste(Image.fromarray(view.pixels), (margin, margin))
    stream = io.BytesIO()
    picture.save(stream, "PNG")
    return stream.getvalue()


def _normals(corners: FloatArray) -> FloatArray:
    """(f, 3) unit normals of triangles (f, 3, 3); zero where a triangle has no area."""
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.sqrt((normal * normal).sum(axis=1))
    length[length == 0.0] = 1.0
    unit: FloatArray = normal / length[:, None]
    return unit


def _edges(surface: IntArray, normals: FloatArray, triangle: IntArray) -> BoolArray:
    """Pixels of solids that lie beside a pixel of another surface, or of a face that turns away sharply."""
    edges = np.zeros(surface.shape, dtype=np.bool_)
    for axis in (0, 1):
        first, second = (np.s_[:, :-1], np.s_[:, 1:]) if axis else (np.s_[:-1], np.s_[1:])
        differs = surface[first] != surface[second]
        other = np.flatnonzero((triangle[first] != triangle[second]) & ~differs)
        cosine = (normals[triangle[first].ravel()[other]] * normals[triangle[second].ravel()[other]]).sum(axis=1)
        differs.reshape(-1)[other[cosine < CREASE_COSINE]] = True
        edges[first] |= differs
        edges[second] |= differs
    return edges & (surface >= 0)

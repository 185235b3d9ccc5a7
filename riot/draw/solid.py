"""Solids in the round, in a parallel view from above at a slant, by a depth buffer. Ours.

No window and no graphics library: every triangle is cut into rows of pixels, and of all that fall on a pixel the
nearest stays. Sums and products only, in a fixed order, so that a picture has the same bytes on any machine.
"""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import manifold3d
import numpy as np
import numpy.typing as npt
from PIL import Image, ImageColor

from riot.types import BoolArray, FloatArray, IntArray

ByteArray = npt.NDArray[np.uint8]

FINER = 2
"""Pixels are means of so many squared."""

_LIGHT = np.array([-0.45, 0.35, 0.82])
"""Towards the light: to the right, upwards, to the eye."""
_DARKEST = 0.42
_EDGE = 0.35
_CREASE = math.cos(math.radians(40.0))
"""Two faces of a body that turn by more from one to the other have an edge between them."""
_BATCH = 1 << 20


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
        out = deep * x - across * y  # the part of a point towards the eye on the plane
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
    """A picture, (rows, columns, 3), white where nothing is, and its size in mm as seen."""

    pixels: ByteArray
    width: float
    height: float


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
    step = mm_per_pixel / FINER
    corners = [eye.view(body.points)[body.triangles] for body in bodies]
    every = np.concatenate([part.reshape(-1, 3) for part in corners])
    low, high = every.min(axis=0), every.max(axis=0)
    # Two pixels of margin, for the edges.
    columns, rows = (FINER * (math.ceil(length / mm_per_pixel) + 4) for length in (high - low)[:2].tolist())
    shift = np.array([low[0], low[1], 0.0]) - 2.0 * FINER * step * np.array([1.0, 1.0, 0.0])
    triangle = nearest_triangles((np.concatenate(corners) - shift) / np.array([step, step, 1.0]), rows, columns)

    owners = np.repeat(np.arange(len(bodies)), [len(part) for part in corners])
    normals = _normals(np.concatenate(corners))
    bright = _DARKEST + (1.0 - _DARKEST) * np.clip((normals * _LIGHT).sum(axis=1), 0.0, 1.0)
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
    image[edges] = (_EDGE * image[edges]).astype(np.uint8)
    return View(np.asarray(Image.fromarray(image[::-1]).reduce(FINER)), columns * step, rows * step)


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


def nearest_triangles(corners: FloatArray, rows: int, columns: int) -> IntArray:
    """(rows, columns) which of the triangles (f, 3, 3) is seen at each pixel's middle, −1 for none.

    ``corners`` are columns, rows, and how near; a triangle that is clockwise is seen from behind, and not drawn.
    """
    depth = np.full(rows * columns, -np.inf)
    nearest = np.full(rows * columns, -1, dtype=np.int64)
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    doubled = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    front = np.flatnonzero(doubled > 0.0)
    pixels = np.maximum(
        1, np.ceil(np.ptp(corners[front, :, 0], axis=1)) * np.ceil(np.ptp(corners[front, :, 1], axis=1))
    )
    batch = (np.cumsum(pixels) // _BATCH).astype(np.int64)
    for number in np.unique(batch).tolist():
        chosen = front[batch == number]
        place, near, triangle = _fragments(corners[chosen], doubled[chosen], columns)
        nearer = near > depth[place]
        place, near, triangle = place[nearer], near[nearer], chosen[triangle[nearer]]
        np.maximum.at(depth, place, near)
        # Backwards, as the last of equal places is what stays: of triangles that are equally near, the first.
        winners = np.flatnonzero(near == depth[place])[::-1]
        nearest[place[winners]] = triangle[winners]
    return nearest.reshape(rows, columns)


def _fragments(corners: FloatArray, doubled: FloatArray, columns: int) -> tuple[IntArray, FloatArray, IntArray]:
    """All middles of pixels in some triangles: which pixel, how near, and which triangle."""
    first = np.ceil(corners[:, :, 1].min(axis=1) - 0.5).astype(np.int64)
    count = np.maximum(0, np.floor(corners[:, :, 1].max(axis=1) - 0.5).astype(np.int64) - first + 1)
    owner, offset = _expanded(count)
    row = first[owner] + offset
    left, right = np.full(len(owner), -np.inf), np.full(len(owner), np.inf)
    y = row + 0.5
    for k in range(3):
        start, stop = corners[owner, k], corners[owner, (k + 1) % 3]
        rise = stop[:, 1] - start[:, 1]
        with np.errstate(divide="ignore", invalid="ignore"):
            at = start[:, 0] + (y - start[:, 1]) / rise * (stop[:, 0] - start[:, 0])
        # Counter-clockwise with rows upwards: what falls is on the left.
        left = np.where(rise < 0.0, np.maximum(left, at), left)
        right = np.where(rise > 0.0, np.minimum(right, at), right)
    begin = np.ceil(left - 0.5).astype(np.int64)
    width = np.maximum(0, np.floor(right - 0.5).astype(np.int64) - begin + 1)
    span, along = _expanded(width)
    triangle, x, y = owner[span], begin[span] + along + 0.5, y[span]
    origin = corners[triangle, 0]
    a, b = corners[triangle, 1] - origin, corners[triangle, 2] - origin
    x, y = x - origin[:, 0], y - origin[:, 1]
    s, t = (x * b[:, 1] - y * b[:, 0]) / doubled[triangle], (a[:, 0] * y - a[:, 1] * x) / doubled[triangle]
    near = origin[:, 2] + s * a[:, 2] + t * b[:, 2]
    return row[span] * columns + begin[span] + along, near, triangle


def _expanded(counts: IntArray) -> tuple[IntArray, IntArray]:
    """For ``counts[i]`` entries of each i: i, and the number of the entry within it."""
    owner = np.repeat(np.arange(len(counts)), counts)
    return owner, np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)


def _edges(surface: IntArray, normals: FloatArray, triangle: IntArray) -> BoolArray:
    """Pixels of solids that lie beside a pixel of another surface, or of a face that turns away sharply."""
    edges = np.zeros(surface.shape, dtype=np.bool_)
    for axis in (0, 1):
        first, second = (np.s_[:, :-1], np.s_[:, 1:]) if axis else (np.s_[:-1], np.s_[1:])
        differs = surface[first] != surface[second]
        other = np.flatnonzero((triangle[first] != triangle[second]) & ~differs)
        cosine = (normals[triangle[first].ravel()[other]] * normals[triangle[second].ravel()[other]]).sum(axis=1)
        differs.reshape(-1)[other[cosine < _CREASE]] = True
        edges[first] |= differs
        edges[second] |= differs
    return edges & (surface >= 0)

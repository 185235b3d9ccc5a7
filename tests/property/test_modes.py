"""Elastic modes: energy, invariance, accuracy, and interiors that are hard to fill with triangles."""

from __future__ import annotations

import numpy as np
import pytest
from blobs import blob

from riot import Shape
from riot.geometry import triangulation
from riot.geometry.bend import strain_energy
from riot.geometry.elements import elements_on
from riot.geometry.modes import Modes, modes, solve_modes
from riot.geometry.polyline import signed_area
from riot.geometry.sides import side_rows, straight_sides
from riot.geometry.triangulation import triangulate
from riot.transform.pose import rotate
from riot.types import FloatArray


def star(tips: int, inner: float) -> Shape:
    angle = np.arange(2 * tips) * np.pi / tips
    radius = np.where(np.arange(2 * tips) % 2 == 0, 1.0, inner)
    return Shape.from_polygon(np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1), f"star-{tips}")


def comb(teeth: int, width: float) -> Shape:
    points = [(0.0, 0.0), (teeth, 0.0), (teeth, 1.0)]
    for tooth in reversed(range(teeth)):
        middle = tooth + 0.5
        points += [
            (middle + width / 2, 1.0),
            (middle + width / 2, 3.0),
            (middle - width / 2, 3.0),
            (middle - width / 2, 1.0),
        ]
    return Shape.from_polygon([*points, (0.0, 1.0)], f"comb-{teeth}")


def open_ring(gap: float) -> Shape:
    """A ring cut open by a gap so narrow that its two ends nearly meet."""
    angle = np.linspace(gap, 2.0 * np.pi - gap, 90)
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return Shape.from_polygon(np.concatenate([ring, 0.8 * ring[::-1]]), "ring")


def dumbbell(neck: float) -> Shape:
    left = [(-1.0, -neck), (-1.0, -1.0), (-3.0, -1.0), (-3.0, 1.0), (-1.0, 1.0), (-1.0, neck)]
    return Shape.from_polygon(left + [(-x, -y) for x, y in left], "dumbbell")


SHAPES = {
    "blob": blob(3),
    "star": star(5, 0.4),
    "spiky star": star(12, 0.3),
    "comb": comb(6, 0.3),
    "thin comb": comb(5, 0.06),
    "ring": open_ring(0.02),
    "neck": dumbbell(0.02),
    "bar": Shape.from_polygon([(0, 0), (25, 0), (25, 1), (0, 1)], "bar"),
}


def energies(bend: Modes, displacement: FloatArray) -> float:
    """∫ |ε|² of a displacement of the nodes."""
    slopes = np.einsum("tqay,tax->tqxy", bend.elements.gradients, displacement[bend.elements.triangles])
    strain = 0.5 * (slopes + slopes.swapaxes(2, 3))
    return float((bend.elements.areas[:, None] / 3.0 * (strain**2).sum(axis=(2, 3))).sum())


@pytest.mark.parametrize("name", SHAPES)
def test_triangles_tile_the_interior(name: str) -> None:
    shape = SHAPES[name]
    mesh = triangulate(shape.points)
    areas = elements_on(mesh).areas
    boundary = mesh.points[: mesh.boundary]
    assert areas.min() > 0.0
    assert areas.sum() == pytest.approx(signed_area(boundary), abs=1e-6)
    assert areas.sum() == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("name", SHAPES)
def test_energy_is_quadratic_and_rigid_motions_cost_nothing(name: str) -> None:
    bend = modes(SHAPES[name])
    nodes = bend.elements.nodes
    rigid = np.stack([0.3 - nodes[:, 1], nodes[:, 0] - 0.2], axis=1)
    assert energies(bend, rigid) < 1e-20
    assert (np.diff(bend.eigenvalues) > -1e-9).all() and bend.eigenvalues[0] > 0.0
    amplitudes = np.random.default_rng(0).normal(size=16) / np.sqrt(bend.eigenvalues)
    mixed = np.einsum("k,kax->ax", amplitudes, bend.vectors)
    assert energies(bend, mixed + rigid) == pytest.approx(float(bend.eigenvalues @ amplitudes**2), rel=1e-6)
    assert energies(bend, 3.0 * mixed) == pytest.approx(9.0 * energies(bend, mixed))


@pytest.mark.parametrize("name", ["blob", "comb", "star"])
def test_energy_of_a_small_map_is_that_of_its_strain_and_none_of_its_turn(name: str) -> None:
    bend = modes(SHAPES[name])
    small = 1e-4 * bend.vectors[0] / np.sqrt(bend.eigenvalues[0])
    slopes = np.einsum("tqay,tax->tqxy", bend.elements.gradients, small[bend.elements.triangles])
    weights = bend.elements.areas[:, None] / 3.0
    assert float((weights * strain_energy(slopes + np.eye(2))).sum()) == pytest.approx(1e-8, rel=0.02)
    turned = np.einsum("xy,tqyz->tqxz", rotate(np.eye(2), 1.0).T, slopes + np.eye(2))
    assert float((weights * strain_energy(turned)).sum()) == pytest.approx(1e-8, rel=0.02)


@pytest.mark.parametrize("name", ["blob", "comb", "neck"])
def test_modes_turn_with_the_shape(name: str) -> None:
    shape = SHAPES[name]
    turned = Shape(rotate(shape.points, 1.0), shape.feature)
    assert modes(turned, straight=0.5).eigenvalues == pytest.approx(modes(shape, straight=0.5).eigenvalues, rel=2e-3)


def test_energy_scales_as_the_square_of_the_size() -> None:
    bend = modes(SHAPES["star"])
    larger = bend.elements.moved(2.0 * bend.elements.nodes)
    eigenvalues, _ = solve_modes(larger, 16, bend.stiffness, 0.0, bend.sides)
    assert 4.0 * eigenvalues == pytest.approx(bend.eigenvalues, rel=5e-3)


def test_a_bar_bends_as_a_beam() -> None:
    # Euler–Bernoulli, free ends: μ = (4.730 / L)⁴ h² / 12, here with L = 5, h = 1/5.
    assert modes(SHAPES["bar"]).eigenvalues[0] == pytest.approx((4.730 / 5.0) ** 4 / 25.0 / 12.0, rel=0.03)


@pytest.mark.parametrize("name", ["blob", "star", "comb", "thin comb", "ring", "neck", "bar"])
def test_eigenvalues_are_near_those_of_a_fine_mesh(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    coarse = modes(SHAPES[name]).eigenvalues
    monkeypatch.setattr(triangulation, "SPACING", 0.5 * triangulation.SPACING)
    monkeypatch.setattr(triangulation, "WIDTH_SHARE", 0.02)
    monkeypatch.setattr(triangulation, "LEVELS", 5)
    ratio = coarse / modes(SHAPES[name]).eigenvalues
    assert 0.99 < ratio.mean() < 1.02
    assert ratio.max() < 1.05


def test_the_same_shape_gives_the_same_bits() -> None:
    for name in ("star", "bar", "blob"):
        first, again = modes(SHAPES[name], straight=0.3), modes(SHAPES[name], straight=0.3)
        assert first.vectors.tobytes() == again.vectors.tobytes()
        assert first.displacements.tobytes() == again.displacements.tobytes()


def test_what_is_kept_is_stiff() -> None:
    shape = SHAPES["comb"]
    left = [(-2.0, -2.0), (0.0, -2.0), (0.0, 2.0), (-2.0, 2.0)]
    soft, stiff = modes(shape), modes(shape, stiffer=[(left, 100.0)])
    assert (stiff.eigenvalues > soft.eigenvalues).all()
    inside = (soft.elements.middles[:, 0] < -0.1).repeat(3)
    for mode in range(4):
        strain = stiff.slopes[mode] + stiff.slopes[mode].swapaxes(1, 2)
        weights = np.repeat(stiff.elements.areas, 3) * (strain**2).sum(axis=(1, 2))
        assert weights[inside].sum() < 0.1 * weights.sum()


def test_straight_sides_and_right_angles_resist() -> None:
    square = Shape.from_polygon([(0, 0), (1, 0), (1, 1), (0, 1)], "square")
    sides = straight_sides(square.points)
    assert len(sides.ends) == len(sides.joints) == 4
    vertices, vectors = side_rows(square.points, sides)

    def cost(displacement: FloatArray) -> float:
        return float((np.einsum("rax,rax->r", vectors, displacement[vertices]) ** 2).sum())

    x, y = square.points.T
    assert cost(np.stack([-y, x], axis=1)) < 1e-20  # a turn
    assert cost(np.stack([x, 0.0 * y], axis=1)) < 1e-20  # a wider rectangle
    assert cost(np.stack([0.1 * y, 0.0 * x], axis=1)) > 0.01  # a parallelogram
    assert cost(np.stack([0.1 * x * (1.0 - 4.0 * y**2), 0.0 * x], axis=1)) > 0.01  # a barrel
    assert modes(square, straight=1.0).eigenvalues[0] > modes(square).eigenvalues[0]


def test_round_shapes_have_no_straight_sides() -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 300, endpoint=False)
    disc = Shape.from_polygon(np.stack([np.cos(angle), np.sin(angle)], axis=1))
    assert len(straight_sides(disc.points).ends) == 0


def test_a_side_that_runs_back_has_finite_stiffness() -> None:
    square = Shape.from_polygon([(0, 0), (1, 0), (1, 1), (0, 1)], "square")
    sides = straight_sides(square.points)
    folded = square.points.copy()
    middle = (sides.ends[0, 0] + sides.ends[0, 1]) // 2
    folded[[middle, middle + 1]] = folded[[middle + 1, middle]]
    _, vectors = side_rows(folded, sides)
    assert np.isfinite(vectors).all()

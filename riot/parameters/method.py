"""Every parameter of the method, with the paper's value as default where the paper gives one.

Lengths are multiples of ``L_c = 2√π``, the perimeter of the unit-area circle, or of ``D_c = 2/√π``, its
diameter, as each field says: every shape has unit area, so that these are absolute. Paper: Li et al.,
*Construction and Fabrication of Reversible Shape Transforms*, ACM TOG 37(6), 190, 2018.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal


@dataclass(frozen=True)
class ShapeParameters:
    """Silhouette → shape (paper §6)."""

    spacing: float = 100.0
    """Consecutive boundary points are closer than ``L_c / spacing``."""
    feature_tolerance: float = 0.006
    """Douglas–Peucker tolerance for the main feature points, in units of ``L_c`` (ours)."""
    vertex_tolerance: float = 5e-5
    """Vertices of a polygon stay boundary points unless the outline without them is off by less than this, in units of
    ``L_c`` (ours; the outlines of pictures and SVG files are known no better than their sampling)."""
    max_pixels: int = 64_000_000
    """A picture with more pixels is refused (ours)."""
    min_pixels: int = 64
    """An object with fewer pixels is refused (ours)."""
    smoothing: float = 1.0
    """Standard deviation, in pixels, of the blur that takes the stair-case off binary pictures (ours)."""


@dataclass(frozen=True)
class ReversibilityParameters:
    """Reversibility score of one shape (paper §5.1)."""

    sigma_pa: float = 1.0
    sigma_w: float = 4.0
    waist_low: float = 0.8
    waist_high: float = 1.2
    simplify: float = 0.01
    """Douglas–Peucker tolerance of the "slightly simplified" boundary, in units of ``L_c`` (ours)."""


@dataclass(frozen=True)
class TrunkParameters:
    """Candidate vertices and trunks (paper §4.1)."""

    spacing: float = 15.0
    """Sparse boundary points are closer than ``d_space = L_c / spacing``."""
    sparse_tolerance: float = 0.03
    """Douglas–Peucker tolerance of the sparse points' features, in units of ``L_c`` (ours)."""
    local: float = 50.0
    """The local outside angle is taken over ``L_c / local`` on either side (ours)."""
    tau_s: float = 0.1
    """Douglas–Peucker tolerance of the simplified boundary (absolute, unit-area shape)."""
    tau_c: float = 0.3
    """Candidate vertices have a greater congruency score than this."""
    sigma_c: float = 0.1
    """Of the congruency score, in units of ``D_c``."""
    min_congruent: float = 0.03
    """The two congruent stretches are together longer than this, in units of the perimeter."""
    min_inside: float = 0.9
    """Least share of a trunk edge that lies inside the shape."""
    min_area: float = 0.01
    """Exterior pieces have more area than this (the shape has 1)."""
    max_arc: float = 0.5
    """Exterior pieces have less boundary than this, in units of the perimeter."""
    max_overlap: float = 0.1
    """Neighbouring congruent stretches overlap by less than this on the boundary between them, in units of ``L_c``."""
    neck_width: float = 0.2
    """Quick trunks leave out points cut off by necks narrower than this, in units of ``D_c``."""
    max_vertices: int = 32
    """No trunk has more vertices (ours). K bounds them first: at most 27 on MPEG-7, where no trunk has more than 10."""
    max_trunks: int = 50_000
    """No shape has more trunks (ours: against symmetric stars); all of an n that passes it and of greater n are left
    out."""


@dataclass(frozen=True)
class QcrsParameters:
    """Quick cross-reversibility score (paper §5.2)."""

    sigma_e: float = 0.1
    """Of the edge term, in units of ``D_c``."""
    sigma_angle: float = math.pi / 6
    sigma_area: float = 0.1


QcrsVariant = Literal["paper", "tuned"]
"""Which trunks QCRS compares: ``paper``: quick trunks. ``tuned``: the full trunks of CRS (ours)."""

QCRS_VARIANTS: Mapping[QcrsVariant, QcrsParameters] = MappingProxyType(
    {"paper": QcrsParameters(), "tuned": QcrsParameters(sigma_area=0.3)}
)
"""Sigmas of each variant. On full trunks the terms of edges and angles are those of CRS. The greater σ_A, the more QCRS
orders pairs as CRS does and the longer the search takes; this one costs what the paper variant does on MPEG-7."""


@dataclass(frozen=True)
class CrsParameters:
    """Cross-reversibility score (paper §4.2)."""

    sigma_e: float = 0.1
    """Of the edge term, in units of ``D_c``."""
    sigma_angle: float = math.pi / 6
    sigma_area: float = 0.3
    lines: int = 128
    """Scanlines of the area term (ours)."""


@dataclass(frozen=True)
class RefineParameters:
    """Conjugate trunks and their refinement (theory §7; all ours)."""

    candidates: int = 16
    """Trunk pairs tried for a pair of shapes, best CRS first."""
    sketched: int = 16
    """Of these the most promising are refined a little; 0 leaves the trunks where CRS has them."""
    sketch_steps: int = 16
    """Most steps of that."""
    refined: int = 3
    """The best of these are refined to the end."""
    steps: int = 48
    """Most steps of that."""
    slide: float = 0.25
    """Refinement moves no trunk vertex farther than this along either axis, in units of ``D_c``."""
    reach: float = 0.1
    """Two arcs part at most this far along the outline from their trunk vertex, in units of ``L_c``."""
    attach: float = 1.0
    """Weight of the squared distances of trunk vertices from the outline: off it the outlines get notches or spikes."""
    lines: int = 128
    """Scanlines of the IoU bound while trunks are refined."""
    bound_lines: int = 512
    """Scanlines of the bound that plans are compared by."""


@dataclass(frozen=True)
class ConstructParameters:
    """Construction (theory §8; all ours but the method "laplacian")."""

    method: Literal["exact", "laplacian"] = "exact"
    """``exact``: the trunk is partitioned. ``laplacian``: the paper's (§4.3); pieces overlap and leave gaps."""
    attempts: int = 2
    """The most promising plans are constructed until so many succeed; the one of least deformation is taken."""
    spacing: float = 400.0
    """Mesh of the partition: points ``L_c / spacing`` apart."""
    tolerance: float = 0.02
    """The dissection's arcs are simplified by Douglas–Peucker to this many mesh spacings."""
    max_cut_off: float = 0.01
    """Greatest area of cells' parts that are cut off from their trunk edge and go to a neighbour."""
    max_lost_contact: float = 0.3
    """Greatest share of a trunk edge that other pieces may cover."""
    snap: float = 0.1
    """Given trunk vertices may lie this far from the outline, in units of ``D_c``."""
    lines: int = 512
    """Scanlines of the areas that change hands where detail is restored."""

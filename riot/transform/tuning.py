"""Numbers of certificates and of measures of deformation: unit, meaning and source of each. All ours.

A result compares with another only if both use the same numbers, so no user sets them. Lengths and areas are those of
unit-area shapes.
"""

from __future__ import annotations

from riot.units import L_C

# Certificate (theory §8)

COVERAGE_TOLERANCE = 1e-9
"""Area: greatest overlap, and greatest gap, that a certificate accepts: above what unions of polygons
lose to rounding, far below what a picture shows."""

HINGE_TOLERANCE = 1e-12
"""Length: greatest distance between the two pieces' positions of one hinge that a certificate accepts: above
rounding of numbers near 1."""

# Deformation (theory §8)

LEAST_CHANGE = 1e-4
"""IoU: a change is compared with the least that the trunks allow only where that is greater; the scanlines of the bound
see no finer."""

BOUNDARY_SAMPLE_STEP = L_C / 400
"""Length: outlines are compared at points this far apart, a quarter of the spacing of an input's points."""

LEAST_BOUNDARY_SAMPLES = 16
"""Points of an outline that are compared, at least."""

# Fidelity

SMOOTHING_SCALE = L_C / 150
"""Length: standard deviation of the smoothing along the boundary, less than the spacing of an input's points
(`L_c / 100`), so that their noise goes and their features stay."""

SAMPLES_PER_SCALE = 3
"""Samples per `SMOOTHING_SCALE`: enough for the second differences of a Gaussian."""

LEAST_SMOOTHED_SAMPLES = 32
"""Samples of an outline, at least."""

DISPLACEMENT_WINDOW = L_C / 15
"""Length along the outline: detail that is displaced by no more can still correspond."""

LONE_STEP_COST = 0.1
"""Radians: cost of a step on one outline only, so that outlines correspond evenly where directions do not tell."""

# Centre lines

CENTRE_LINE_STEP = L_C / 400
"""Length: side of the grid's cells that a shape is drawn on to find its centre line; less than half the width of the
limbs that a unit-area shape has at a hundred points along its outline."""

LEAST_TIP = 0.008
"""Share of a shape's centre line below which a lost section of it does not count: a corner that is rounded."""

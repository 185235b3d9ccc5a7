"""Numbers of textures that no user sets: unit, meaning and source of each. All ours.

They are apart from `riot.draw.tuning` because painted textures are results that are stored: the numbers of other
pictures must not make them be painted again. Lengths without a unit are those of unit-area shapes.
"""

from __future__ import annotations

# Textures

PATTERN_WIDTH = 0.06
"""Length: width of a band, stripe or check."""

BANDS_CELL = PATTERN_WIDTH / 16.0
"""Length: cell of the raster of distances from the outline, fine enough for smooth bands."""

IMAGE_PIXEL = 1.0 / 240.0
"""Length: side of an image's pixel, about a pixel of a page's pictures."""

IMAGE_RIM = 2.0
"""Pixels of an image beyond its piece: what writers smooth at the edge must not be white."""

MAX_PICTURE_PIXELS = 64_000_000
"""A picture with more pixels is refused."""

LEAST_OVERLAP = 0.9
"""IoU: least of a picture's opaque region, holes filled, with the shape's outline."""

MIXED_RIM = 2
"""Pixels at the rim of an object that have something of the background's colour, and are not used."""

CHECK_SIDE = 1024
"""Pixels: a picture is compared with the shape at about this side."""

# Warp of an assembled shape to its input (theory §9)

WARP_SPACING = 0.022
"""Length: distance of the triangulation's points, some 2,500 points a shape."""

MATCH_STEP = 0.012
"""Length: arcs are matched at points so far apart."""

LEAST_MATCH_STEPS = 8
"""Steps in which an arc is matched, at least."""

STRETCH_COST = 1e-5
"""Area (a squared distance): cost of a step that stretches one arc against the other; ties go to even arc length."""

SMOOTHING_REACH = 3
"""Steps on either side over which a match is averaged."""

SLIVER_SHARE = 0.1
"""Spacings: vertices of both outlines that match more nearly than this are matched with each other."""

OUTLINE_DISTANCE = 0.6
"""Spacings: inner points keep this distance from the outline."""

SPLIT_ROUNDS = 40
"""Rounds in which boundary edges are split until the triangulation has them all."""

UNFOLD_SWEEPS = 12
"""Sweeps, at most, over the points of triangles that are mirrored in the input."""

LEAST_AREA_RATIO = 1e-3
"""A triangle that shrinks below this share of its area counts as mirrored, and is mended."""

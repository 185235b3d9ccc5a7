"""Numbers of pictures that no user sets: unit, meaning and source of each. All ours.

They change how pictures look, never a result. A pen is about a pixel; lengths without a unit are those of unit-area
shapes.
"""

from __future__ import annotations

import math

# Outlines and names

SKETCH_TOLERANCE = 5e-4
"""Length: outlines are drawn within this distance of the truth, a tenth of a pixel in most pictures."""

CAPTION_LENGTH = 28
"""Characters: longer names would run into each other."""

# Figures and strips

PNG_WIDTH = 1600
"""Pixels across a PNG whose width is not given."""

PDF_WIDTH_MM = 254.0
"""Millimetres: width of a page without a size of its own."""

FIGURE_PENS = 960.0
"""Pens: width of the figure of a transform."""

FIGURE_TIMES = (0.0, 0.2, 0.4, 0.5, 0.6, 0.8, 1.0)
"""Times of the motion, 0 = P and 1 = Q, whose poses the figure shows."""

STRIP_PENS = 1280.0
"""Pens: width of a strip."""

STRIP_POSES = 7
"""Poses in a strip."""

# Motion

MOTION_PENS = 520.0
"""Pens: width of films and animated SVGs."""

SWEPT_MARGIN = 0.05
"""Length: margin around all poses. The path between two key frames leaves their box by the height of a small arc."""

STILL_TIME = 0.35
"""Time of the pose for readers who ask for less motion: all pieces apart, P still recognisable."""

MAX_TURN = math.radians(10.0)
"""Radians: most that a piece turns between two frames, so that straight steps look rigid."""

WAY_FRAMES = 40
"""Frames of one way, or more if pieces turn far."""

PAUSE_FRAMES = 14
"""Frames of one pause."""

LOOP_SECONDS = 8.0
"""Seconds of one loop of `WAY_FRAMES`: a pause as P, the way there, a pause as Q, the way back. More frames take
longer."""

LIFTING_RADIUS = 4.5
"""Pens: radius of a telescopic hinge's dot."""

FILM_WIDTH = 640
"""Pixels across a film whose width is not given."""

MP4_RATE = 30
"""Frames a second of an MP4; a GIF has as many as the animated SVG has key frames."""

MP4_QUALITY = 7
"""Quality of an MP4 by imageio-ffmpeg's scale of 0 to 10."""

GIF_COLOURS = 128
"""Colours of a GIF, the same in all its frames."""

PALETTE_FRAMES = 6
"""Frames of a film, about, from which its colours are taken."""

PALETTE_CELL = 8
"""Levels of a channel: Pillow looks colours up in cells of this size."""

# Solids

SUPERSAMPLING = 2
"""Pixels of a view of solids are means of so many squared."""

LIGHT_DIRECTION = (-0.45, 0.35, 0.82)
"""Towards the light: to the right, upwards, to the eye; of length 1 within a percent."""

DARKEST_FACE = 0.42
"""Share of its colour that a face turned from the light has."""

EDGE_SHADE = 0.35
"""Share of its colour that a pixel on an edge has."""

CREASE_COSINE = math.cos(math.radians(40.0))
"""Two faces of a body that turn by more from one to the other have an edge between them."""

BATCH_PIXELS = 1 << 20
"""Pixels of triangles that are cut into rows at once: bounds the memory."""

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

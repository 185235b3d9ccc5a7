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

# Notebooks

NOTEBOOK_SCALE = 160.0
"""Pixels of a unit in a notebook's pictures: a disc of unit area is 180 pixels wide."""

NOTEBOOK_PIXELS = 400.0
"""Pixels: greatest height of a notebook's picture, half of its greatest width."""

GRID_TRUNKS = 12
"""Trunks that a notebook shows at once, unless it is told which."""

GRID_SCALE = 90.0
"""Pixels of a unit in their picture."""

GRID_COLUMNS = 6
"""Of them in a row."""

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

TURN_FRAMES = 14
"""Frames in which a film turns the puzzle over."""

LOOP_SECONDS = 8.0
"""Seconds of one loop of `WAY_FRAMES`: a pause as P, the way there, a pause as Q, the way back. More frames take
longer."""

LIFTING_RADIUS = 4.5
"""Pens: radius of a telescopic hinge's dot."""

FILM_WIDTH = 640
"""Pixels across a film whose width is not given."""

MP4_RATE = 25
"""Frames a second of an MP4; a GIF has as many as the animated SVG has key frames."""

MP4_QUALITY = 18
"""Constant rate factor of an MP4, x264's scale from 0 (no loss) to 51: 18 and less look like the original."""

FILM_MARGIN_PENS = 7.0
"""Pens that dots and lines reach beyond their points, at most."""

MP4_PRESET = "veryfast"
"""How long x264 looks for what repeats; a tenth more bytes than by its own choice, in a third of the time."""

FILM_SUPERSAMPLING = 3
"""Pixels of a film's frame are means of so many squared."""

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

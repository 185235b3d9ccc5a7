"""Numbers of fabrication that no user sets: unit, meaning and source of each.

What a user may set is in `riot.parameters.fabrication`. "Makers" is makers' literature on printing by filament with a
nozzle of 0.4 mm and layers of 0.2 mm; nothing here is measured on prints of our own. All others are ours.
"""

from __future__ import annotations

import math
from typing import NamedTuple

# Flat regions

GRID_MM = 0.001
"""mm: all points of flat regions lie on a grid of this step, far below what a printer can do."""

DISC_SIDES = 64
"""Sides of the regular polygon that stands for a disc: a disc of 5 mm is off by 0.006 mm at most."""

QUARTER_SEGMENTS = 8
"""Segments of a quarter circle around the corners of a region that grows or shrinks."""

SMOOTHING_MM = 0.005
"""mm: an outline loses points that are nearer to the line through its other points."""

OUTLINE_SPARE_MM = SMOOTHING_MM + 2.0 * GRID_MM
"""mm: an outline loses so much more than half the gap, so that neither smoothing nor the grid narrows the gap."""

CRUMB_SHARE = 0.01
"""Share of a piece that may break off where the piece is narrower than the outline gap: nobody misses it."""

SLIVER_MM2 = 1e-7
"""mm²: two layers that share less touch by rounding only; a tenth of a cell of the grid."""

HEIGHT_DIGITS = 6
"""Decimals of heights in mm: heights that differ by rounding only become one."""

SLIT_REACH_MM = 1.0
"""mm: the region of a rod's slit ends so far outside the rod, so that it cuts the rod through."""

# Narrow necks

NECK_STEPS, NECK_HALVINGS = 12, 5
"""The width of a neck is searched in so many steps up to a knuckle's diameter, and then halved so many times: exact to
1/384 of the diameter."""

KNUCKLES_PER_NECK = 3.0
"""A neck counts if more than the area of a knuckle, divided by this, hangs on it."""

# Motion

GREATEST_TURN = math.radians(2.0)
"""Radians: one piece turns by no more against another between two samples of the motion."""

SAGITTA_MM = 0.02
"""mm: a point 120 mm away leaves the straight line between two samples by that; sweeps grow by it."""

SWEEP_QUARTER_SEGMENTS = 16
"""Segments of a quarter circle around what a knuckle sweeps; the sweep grows by what the segments cut off."""

GAP_CAP_MM = 3.0
"""mm: gaps beyond this need not be exact; far above any gap that is asked for."""

SHAVE_ROUNDS = 12
"""Rounds, at most, in which pieces lose what comes too near between samples; the certificate judges what is left."""

SHAVE_SAMPLES = 33
"""Samples that replace two neighbouring steps of the motion where pieces come too near."""

SHAVE_MARGIN_MM = 0.01
"""mm: pieces lose so much beyond the gap, for what happens between samples."""

SAME_CLEARANCE_RATIO = 1.005
"""Clearances whose ratio is less are the same: 0.35 mm of 120 mm are 0.00292, rounded."""

# Slopes

SLOPE = math.tan(math.radians(34.0))
"""How far a slope leans out over its height: 34°, since slicers' presets ask for supports beyond 35°."""

# Pin hinge

HEAD_STEP_MM = 0.8
"""mm: a pin's head, or a rod's cap, is so much wider than the pin all round; two lines of a nozzle of 0.4 mm."""

HEAD_RIM_MM = 1.0
"""mm: height of a head's straight rim, in whole layers; five layers of 0.2 mm, which hold a cap on its rod."""


class Screw(NamedTuple):
    """Countersunk screw and its nut, mm: diameter of the head, width across flats and height of the nut."""

    head: float
    across: float
    nut: float


SCREWS = {2.0: Screw(3.8, 4.0, 1.6), 2.5: Screw(4.7, 5.0, 2.0), 3.0: Screw(5.5, 5.5, 2.4), 4.0: Screw(8.4, 7.0, 3.2)}
"""By nominal diameter: greatest heads of ISO 7046 and ISO 14581, and nuts of ISO 4032."""

SCREW_LENGTHS_MM = (5.0, 6.0, 8.0, 10.0, 12.0, 16.0, 20.0, 25.0, 30.0)
"""mm: preferred lengths of ISO 7046, heads included."""

NUT_PLAY_MM = 0.1
"""mm: a nut's pocket is so much larger on every side."""

NUT_FLOOR_MM = 1.0
"""mm: least height of the plastic that a nut pulls against; five layers of 0.2 mm."""

PULL_LAYERS = 2.0
"""Layers of the printer: a knuckle that is pulled so far beyond its clearance over `SLOPE` must meet its pin's head."""

# Cone hinge, printed in place

CONE_HOLD_MM = 0.6
"""mm: the rims of the pin are so much wider than the narrowest place of the socket, in radius; more than one line of a
nozzle of 0.4 mm."""

WAIST_HEIGHT_MM = 0.4
"""mm: height of the pin's waist, in whole layers; two layers of 0.2 mm."""

THINNEST_WAIST_MM = 2.0
"""mm: a pin that is printed in place is made no thinner than this, at its waist; five lines of a nozzle of 0.4 mm."""

CONE_TURNS = 8
"""Turns of a pin in its socket at which the gap is measured: around the circle, and within a side of its polygon."""

CONE_SEARCH_MM = 0.1
"""mm: the gap of a cone hinge is searched up to so much more than the clearance: a wider search takes minutes."""

PULL_DIRECTIONS = 6
"""Directions sideways in which a pin is pulled against its socket."""

PULL_HALVINGS = 4
"""How far a pin can be pulled is halved so many times: exact to a sixteenth of what is allowed, 0.06 mm."""

# Pose in which a chain is printed in place

IN_PLACE_POSES = 65
"""Poses of the motion that a chain may be printed in."""

IN_PLACE_APART_MM = 2.0
"""mm: pieces of a chain that are printed in place need not be further apart; five lines of a nozzle of 0.4 mm."""

PLACED_SEARCH_MM = 0.1
"""mm: the distance of two pieces on the bed is searched up to so much more than the clearance."""

# Trays

TRAY_GAP_MM = 0.6
"""mm: room around the puzzle in its tray; it is put in by hand, and its hinges have play."""

TRAY_WALL_MM = 4.0
"""mm: least wall of a tray."""

TRAY_FLOOR_MM = 1.6
"""mm: floor of a tray, in whole layers; eight layers of 0.2 mm."""

TRAY_DEPTH_SHARE = 0.6
"""Depth of a recess over the thickness of the puzzle, in whole layers: the rest is there to hold."""

# Magnets in the walls at the open hinge

MAGNETS_MM = (3.0, 4.0, 5.0, 6.0, 8.0)
"""mm: usual diameters of disc magnets; of these the next smaller one that fits is proposed where one does not."""

MAGNET_FIT_MM = 0.1
"""mm: a magnet's pocket is so much larger on every side, and deeper: it is pushed in with a drop of glue."""

MAGNET_RECESS_MM = 0.3
"""mm: where a wall is not straight, a magnet's face may be so much behind its chord: two magnets are no further apart
than the outline gap and twice this."""

MAGNET_STEP_MM = 0.5
"""mm: places for magnets are tried in such steps along a wall."""

POCKET_MOUTH_MM = 1.0
"""mm: the region of a pocket begins so far outside the magnet's face: beyond the wall, and within the next piece."""

SAME_WALL_MM = 0.01
"""mm: walls of two pieces of a closed shape that are nearer are one; they differ by rounding only."""

# Telescopic hinge

LEDGE_RIM_MM = 0.4
"""mm: height of the straight rim of ledges, flange and knob, in whole layers; two layers of 0.2 mm."""

LIP_HEIGHT_MM = 0.6
"""mm: height of the barrel's lip, in whole layers; three layers of 0.2 mm, which must bend and snap back."""

LEAST_CAP_MM = 1.2
"""mm: least height of the cap; six layers of 0.2 mm."""

CAP_SHARE_DIVISOR = 3.0
"""The cap is no higher than the hinge divided by this, so that most of the height is left for travel."""

SNAP_MM = 0.15
"""mm: the barrel's lip stands so far in the flange's way, in radius; half the gap of the nested cylinders."""

LEDGE_OVER_GAP_MM = 0.5
"""mm: a ledge that is too narrow is told to be so much wider than the gap."""

LEAST_ROD_MM = 1.5
"""mm: least radius of the rod, which is slit and printed upright."""

SLIT_SHARE = 0.6
"""Share of the rod below the barrel's top that the slit opens: the knob bends, the rest stays stiff."""

SPARE_TRAVEL_MM = 0.4
"""mm: the hinge travels so much beyond what the motion needs."""

# Weaknesses that the design warns of

NARROW_CORNER = math.radians(25.0)
"""Radians: a narrower corner at a hinge is weak."""

STRONG_WALL_MM = 1.6
"""mm: two such walls are strong enough, however thick the knuckles' are; makers: four lines of a nozzle of 0.4 mm."""

LARGE_LOSS_SHARE = 0.02
"""Share of a piece's area that other hinges take before the design warns."""

# Certificate

LENGTH_TOLERANCE_MM = 2e-3
"""mm: lengths that fall short by less are as asked for; twice the grid of flat regions."""

HEIGHT_TOLERANCE_MM = 1e-6
"""mm: heights that differ by less are the same; the last decimal of `HEIGHT_DIGITS`."""

VOLUME_TOLERANCE = 1e-6
"""Share: volumes whose relative difference is less are the same; the solids are exact but for rounding."""

OVERLAP_TOLERANCE_MM3 = 1e-6
"""mm³: two solids that share less do not overlap."""

LARGEST_HINGE_SHARE = 0.25
"""Share of a piece's area that discs around its hinges may take: beyond it the piece is hardly more than hinges."""

STEEPEST = math.radians(45.0)
"""Radians from the vertical: no wall may lean out further over the layer below; makers: the usual limit."""

LONGEST_BRIDGE_MM = 8.0
"""mm: no bridge between two sides of the layer below may be longer; makers: 10 mm and more bridge without supports."""

LEAST_WALL_MM = 0.8
"""mm: nothing thinner prints reliably; makers: two lines of a nozzle of 0.4 mm."""

KNUCKLE_SHARE = 0.25
"""A layer holds something of a knuckle if it covers more than this share of the knuckle's disc."""

OVERLAP_POSES = 7
"""Poses, from P to Q, at which solids are cut with each other; more if pieces lift."""

GAP_SEARCH_MM = 2.0
"""mm: the distance of two cylinders of a telescopic hinge is searched up to this; parameters allow gaps up to 0.6."""

PULL_SHARES = (0.0, 0.5, 1.0)
"""Shares of the travel at which the cylinders of a telescopic hinge are cut with each other."""

STOP_SLACK_MM = 1e-3
"""mm: the sleeve is this far below its stop where the rod's stop is tested, so that their faces do not touch."""

PAST_STOP_MM = 0.1
"""mm: a sleeve that is raised this far past its stop must overlap the barrel."""

PAST_STOP_LAYERS = 0.5
"""Layers of the printer: a rod that is raised this far past its stop must overlap the sleeve."""

# What `fix` changes

SIZE_FACTOR = 1.25
"""A size grows by this factor at a time if nothing tells how much is enough."""

VANISHED_SIZE_FACTOR = 2.0
"""A piece that is nowhere wider than the gap asks for a size that is larger by this factor."""

FILAMENT_MM = 1.75
"""mm: diameter of the filament that serves as a thinner pin; makers: the usual filament."""

WALL_STEP_MM, GREATEST_WALL_MM = 0.6, 4.0
"""mm: walls of knuckles grow by so much at a time, and up to this."""

# Plates of a printer

BED_SPACE_MM = 4.0
"""mm: distance of two parts on a plate, and of a part from the bed's edge; a brim fits between."""

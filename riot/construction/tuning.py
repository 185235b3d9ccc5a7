"""Numbers of construction that no user sets: unit, meaning and source of each. All ours; the paper gives only one.

What a user may set is in `riot.parameters`. Lengths are in the unit-area frame where no unit is named.
"""

from __future__ import annotations

from riot.units import D_C, L_C

# Conjugate trunks (theory §7)

EDGE_TOLERANCE = 1e-14
"""Length: the iteration ends when corresponding edges differ by no more. A few roundings of numbers near 1."""

ACCEPTED_EDGE_DIFFERENCE = 100.0 * EDGE_TOLERANCE
"""Length: trunks count as conjugate if their edges differ by no more. As the certificate's hinges."""

CONJUGATE_STEPS = 50
"""Gauss–Newton steps at most; trunks that have not settled by then are refused."""

FULL_TURN_TOLERANCE = 1e-6
"""Radians: a polygon goes round once if its turns add up to 2π within this. Far above rounding, far below a turn."""

# Trunks that a user gives

MERGE_DISTANCE = 1e-9
"""Length along the outline: boundary points closer than this are one. Above rounding, below any detail."""

# Refinement (theory §7)

SHARPNESS = (60.0, 240.0)
"""1 / IoU: refinement maximises −log(Σ exp(−s b)) / s, which approaches the lesser bound b as s grows. The first s is
smooth enough to climb far, the second sharp enough to end near the lesser bound's own maximum."""

FIRST_MOVE = 0.02
"""Length, over all corners: the first step, taken while nothing is known of the curvature."""

LONGEST_MOVE = 0.2
"""Length, over all corners: no step is longer, because the surface of conjugate trunks is curved."""

MOVE_HISTORY = 8
"""Steps from which the quasi-Newton direction takes the curvature; a usual memory of L-BFGS."""

MOST_BACKTRACKS = 5
"""Trials of shorter steps along one direction, at most."""

BACKTRACK_FACTOR = 0.4
"""A step that gains too little is shortened by this factor."""

ARMIJO_SHARE = 1e-4
"""A step is taken if it gains this share of what the slope promises; the usual constant of the Armijo rule."""

LEAST_CURVATURE = 1e-12
"""A step is remembered if the function curves down along it by more than this: the direction stays an ascent."""

SETTLED_GAIN = 1e-5
"""IoU: refinement ends when a step gains less. A tenth of `WORTHWHILE_GAIN`."""

WORTHWHILE_GAIN = 1e-4
"""IoU: a plan stays where it is unless its bound rises by more: the scanlines of the bound see no finer, and trunks
that are exact already must not move."""

# Partition and dissection tree (theory §8)

LEAST_RINGS = 4
"""Rings of a trunk's mesh, at least, so that the cells of a small trunk still have an inside."""

INWARD_SHARE = 1e-9
"""Share of the way to the trunk's middle by which mesh points are moved before a point is inside or outside a piece:
on a trunk edge itself a piece neither begins nor ends."""

CONTACT_SLACK = 0.25
"""Mesh spacings: another piece covers a boundary point if it reaches over it by more. The mesh shows no less."""

CORNER_SHARE = 0.1
"""Where a third piece covers a corner of the trunk, the cells of the two edges that meet there keep this share of the
mesh edges around it, so that every cell reaches both corners of its edge."""

COINCIDENT_NODES = 1e-9
"""Length: points of the dissection tree closer than this are one."""

# Exact plans

EXACT_BOUND = 0.9993
"""IoU: a plan with a greater bound is as good as exact, for the scanlines of a maximisation see no finer. It is not
bent, and its transform must not lose what lies between the points of the partition's mesh."""

EXACT_LOSS = 1e-4
"""IoU: an exact plan whose transform loses more is dissected on a finer mesh."""

FINER_MESH = 4.0
"""So many times as fine: then of 804 exact pairs (3–6 pieces) given as polygons the worst has an IoU of .9998."""

# Matching of tree arcs and swung arcs (theory §8)

LEAF_RADIUS = 0.02
"""L_c: within this distance of a leaf a tree arc neither turns back nor leaves the trunk."""

COINCIDENT_SAMPLES = 1e-7
"""Length: samples of a tree arc closer than this are one."""

EMPTY_BAR_FACTOR = 4.0
"""A bar between two junctions beside which neither swung arc has anything is contracted up to so many times the length
`contract` of `riot.parameters.DetailParameters`."""

EMPTY_SHARE = 0.5
"""Sample steps: a section of a swung arc shorter than this has nothing on it."""

EDGE_CLEARANCE_SHARE = 0.003
"""The tree keeps this share of the distance from the nearest corner off the trunk's edges, and of L_c at most."""

LEAF_CLEARANCE_FACTOR = 1.5
"""Near a leaf only samples stay that keep so many times `EDGE_CLEARANCE_SHARE` off the edges: room for the solution."""

CORNER_TURN = 0.35
"""Radians: a vertex of a swung arc that turns by more than this is a corner, to which a junction may go."""

CORNER_TURN_DIFFERENCE = 1.0
"""Radians: the corner must turn as the tree does at the junction, but for this."""

FEATURE_TURN_WINDOW = 2.0
"""Sample steps: length over which the turn of a swung arc at a feature is measured."""

JUNCTION_TURN_WINDOW = 4.0
"""Sample steps: the same for the tree at a junction; its middle lines are rounder."""

LEAST_FEATURE_TURN = 1e-9
"""Radians: the turn of a feature that does not turn, so that it stays a feature; 0 marks the other vertices."""

PARTITION_DISTANCE_WEIGHT = 0.1
"""How much a corner's distance from the partition's junction counts against its distance from the swung arcs."""

CORNER_SLACK = 0.3
"""Snapping distances: an arc's own corner is as near as the arc if it is farther by less than this."""

POSITION_ROUNDING = 1e-12
"""Length along an arc: vertices nearer to the end of a section than this count as the end."""

# Detail (theory §8)

DRAW_BACK_ROUNDS = 8
"""How often the tree is drawn back towards the middle lines, each time over twice the length, before they stay."""

CROSSING_REACH = 3.0
"""Sample steps: a crossing is drawn back so far on either side in the first round."""

DRAW_BACK_PLATEAU = 2.0
"""Reaches from a crossing at which drawing back ends; it is complete up to one reach less."""

FIRST_DISPLACEMENT_CAP = 2.0
"""Greatest displacements from the middle lines: beyond it samples are drawn back first where too much area is lost."""

DISPLACEMENT_CAP_FACTOR = 0.5
"""That cap shrinks by this factor from round to round."""

JUNCTION_HOLD = 1000.0
"""How much harder a junction is drawn to its position than a displacement over the reach resists."""

EVEN_SHARE = 0.2
"""Share of the even correspondence in that of samples with the middle lines, so that it never stands still."""

LEAST_SAMPLE_DISTANCE = 0.1
"""Sample steps: samples nearer to each other count as so far apart, or the system would be too stiff to solve."""

COLLINEAR_DISTANCE = 1e-7 * L_C
"""Length: samples this near to the chord over them are left out."""

# Pins (theory §8)

PIN_TOLERANCE = 1e-4 * L_C
"""Length: a pinned section is met to this distance, except within `LEAF_RADIUS` of a hinge, which the outline meets
straight."""

PIN_REACH = 0.05 * D_C
"""Length: pins may lie this far from the outline."""

KEPT_POINT_REACH = L_C / 100
"""Length along the outline: a kept point stands for this much on either side; the spacing of an input's points."""

PIN_WEIGHT = 1e14
"""Weight of a pinned sample: greater than any stiffness of the system by enough to meet `PIN_TOLERANCE`."""

PIN_POSITION_SLACK = 1e-9
"""Length along an arc: a sample this near to the end of a pinned section belongs to it."""

SECTION_SLACK = 1e-8
"""Length along an arc: a section shorter than this comes from rounding where pins end at a hinge."""

HINGE_REACH = 0.1 * D_C
"""Length: a line that is drawn over a hinge may pass it in this distance, and is led through it."""

KEEP_TRIES = 16
"""Parts of a stretch that are tried, the longest first, until what can be kept of it is known."""

PIN_CHECKS = 33
"""Even points of a pinned section, besides its vertices, at which its distance from the cut is measured."""

# The paper's Laplacian method (paper §4.3)

EDIT_STEP = 0.003
"""Length: the deepest point moves so far at once (paper §4.3)."""

CONTACT_DISTANCE = 0.00075
"""Length: points nearer than this to another arc are in contact, and what is no deeper is left. A quarter of
`EDIT_STEP`: twice as much leaves twice the areas, less deforms the shapes more."""

POINT_SPACING = L_C / 200
"""Length: before each round points are put between those of the arcs until they are closer than this."""

MOST_EDIT_STEPS = 1000
"""Steps of a phase, at most; some 200 are enough for most trunks."""

MOST_EDIT_ROUNDS = 6
"""Overlaps are parted and gaps closed so often, at most."""

RESIDUAL_TOLERANCE = 1e-3
"""Area: rounds end when gaps, overlaps and outside of a trunk are less together, or when a round gains less."""

LEAST_ARC_SCALE = 0.5
"""An arc that would have to be scaled below this share of its height to stay in the trunk is not scaled."""

SCALE_TRIALS = 51
"""Scales that are tried, evenly spaced from 1 down to `LEAST_ARC_SCALE`."""

RESIDUAL_LINES = 2048
"""Scanlines of the residual areas where the caller gives no number."""

# Bending (theory §12)

LEAST_STARTS, MOST_STARTS = 3, 8
"""Vertices of the trunk pairs that are looked for by their number: a trunk has three at least, and a puzzle of more
than eight pieces is a patience."""

NEAR_COPY = 0.03 * D_C
"""Length: of plans whose corners all lie nearer to those of a better one, only that one is bent."""

HELD_CONTACT, HELD_STARTS = 8.0, 3
"""Where no bent plan can be cut: so many times as many plans are bent, and contact weighs so many times as much."""

SOFTEST = 4.0
"""Eigenvalue below which a mode's step is measured by how far it moves the shape, and no more by its energy."""

CONTACT_SAMPLES = 24
"""Points of a trunk edge at which its own piece and the others are compared."""

CONTACT_INSET = 1e-6
"""Share of the way to the trunk's middle by which these are moved inwards, as `INWARD_SHARE`."""

CONTACT_RAMP = L_C / 200
"""Length: by so much more another piece is nearer where contact counts as lost altogether. Wide enough for a gradient,
narrow beside a piece."""

SPARE_CONTACT = 0.5
"""Share of the contact that may be lost at which its cost begins: room for what the samples do not see."""

FLAT_TURN = 0.05
"""Sine: corners that turn by less cost something, so that trunks stay convex without standing at the limit."""

FLAT_WEIGHT = 0.01
"""IoU: what a corner costs that does not turn at all; it costs in proportion to the square of what is missing."""

FULLEST_STRAIN = 0.98
"""Share of the strain that is allowed to which amplitudes are made smaller that exceed it: room for what is not in
proportion."""

STRAIN_TRIALS = 4
"""How often amplitudes are made smaller until the strain is as allowed; after that the step is refused."""

LEAST_KEPT_AREA = 0.05
"""Share of its area that every triangle keeps where modes are computed anew. Limits of strain hold but for a little
area, and elements that are folded have no energy."""

LARGE_TURN = 0.2
"""Radians: where the interior turns by more anywhere, modes are computed anew on the bent shape."""

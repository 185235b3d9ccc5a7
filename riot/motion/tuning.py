"""Numbers of motion planning that no user sets: unit, meaning and source of each. All ours (theory §9).

What a user may set is in `riot.parameters.MotionParameters`. Hinges count their turns in shares of the whole turn from
P to Q.
"""

from __future__ import annotations

# Bodies

SIMPLIFY_SHARE = 0.2
"""Share of half the gap by which the bodies' outlines may be simplified; they are shrunk by that much less."""

QUARTER_SEGMENTS = 8
"""Segments of a quarter of a circle, where outlines are shrunk and relieved: within 0.5 % of the radius."""

# Collision

CONTACT_SHARE = 0.25
"""Share of half the gap: two bodies that are nearer are in contact. Shrinking leaves 0.6 of it at least."""

DISTANCE_CAP = 0.25
"""Length in the unit-area frame: greater distances need not be exact."""

# Searches

MOST_ORDERED_TURNS = 12
"""Hinges: subchains with as many or more are not tried one hinge at a time, because the orders would be too many."""

UNIFORM_SHARE = 0.5
"""Share of random poses drawn evenly; the others lie close to known ones, because the way out of a closed chain is
narrow."""

POSE_SPREAD = 0.2
"""Shares of whole turns: standard deviation of the random poses around known ones."""

STEP_BACK = 0.8
"""Share that is taken of a way that is not free to its end, so that the next way does not begin in contact."""

LEAST_STEP = 0.02
"""Shares of whole turns: a shorter step is not taken."""

"""Construction: refined conjugate trunks, the partition and its tree, exact transforms (theory §7, §8)."""

from riot.construct.choose import alternatives, construct
from riot.construct.draft import Draft, draft_plan
from riot.construct.make import construct_plan
from riot.construct.pins import Pins, draw, keep, load_pins

__all__ = ["Draft", "Pins", "alternatives", "construct", "construct_plan", "draft_plan", "draw", "keep", "load_pins"]

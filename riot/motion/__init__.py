"""Motion of a transform's pieces from P to Q without collision, as few hinges lifting as can be (theory §9)."""

from riot.motion.motion import Attempt, Motion
from riot.motion.parameters import MotionParameters
from riot.motion.planner import plan_motion

__all__ = ["Attempt", "Motion", "MotionParameters", "plan_motion"]

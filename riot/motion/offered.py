"""What ``riot.motion`` offers."""

from riot.motion.motion import Attempt, Motion
from riot.motion.parameters import MotionParameters
from riot.motion.planner import plan_motion

__all__ = ["Attempt", "Motion", "MotionParameters", "plan_motion"]

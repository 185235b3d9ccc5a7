"""What ``riot.motion`` offers."""

from riot.motion.planner import plan_motion
from riot.parameters.motion import MotionParameters
from riot.transform.motion import Attempt, Motion

__all__ = ["Attempt", "Motion", "MotionParameters", "plan_motion"]

from . import bodies as bodies
from . import planner as planner
from . import search as search
from .planner import Attempt as Attempt
from .planner import Motion as Motion
from .planner import MotionParameters as MotionParameters
from .planner import plan_motion as plan_motion

"""How a transform's pieces swing from P to Q without collision, as few hinges lifting as can be (ours).

`plan_motion` returns a `riot.transform.motion.Motion`, which is data. A planned motion is free of collisions at every
moment, proven by distances and not by samples; the same transform gives the same motion (tests/unit/test_motion.py,
tests/property/test_motion_collide.py).
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

"""What a run would do, and why: the plan by stage, and which part of a key changed since the nearest stored artifact.

Nothing here computes or writes; tests/property/test_causes.py makes every kind of edit and asks for its cause.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

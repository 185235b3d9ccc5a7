"""Exact reversible pairs without end, to test against (ours).

A pair is made from its transform, so that the pieces are known and the deformation is nought; the same seed gives the
same pair (tests/property/test_groundtruth_properties.py).
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

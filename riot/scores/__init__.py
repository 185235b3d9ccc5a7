"""Scores of one shape and of two: reversibility, candidate trunks, QCRS, CRS, and the index (paper §4.1, §4.2, §5).

Scores do not change when a shape is rotated or moved, or its outline starts elsewhere, and the fast paths agree with
brute force (tests/property/test_pair_scores.py, test_crs.py, test_candidate_trunks.py,
test_reversibility_properties.py).
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

"""From two shapes to an exact transform: conjugate trunks, the partition, pieces, pins (paper §4.3).

A transform made here passes its certificate or is not returned; the paper's Laplacian method, in `laplacian`, is the
exception, kept to compare with. Every number of tuning stands in `riot.parameters`
(tests/property/test_construction.py, test_refinement.py, test_pins.py).
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

"""The paper's own construction, by Laplacian editing (paper §4.3), kept to compare with: not exact.

Its pieces overlap and leave gaps; `residual` measures how much. It knows no pins and no certificate, and the same plan
gives the same bytes (tests/property/test_laplacian_construction.py, test_laplacian_editing.py).
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

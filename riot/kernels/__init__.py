"""Numba kernels: plain arrays in and out, one module a hot loop; geometry, policy and files stay outside.

Fast mathematics stay off (`options`), so that the same input gives the same bits in every process. A module's ``warm``
compiles its kernels; an edit compiles them again, which takes minutes (tests/unit/test_kernels.py).
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

"""How kernels get compiled: which modules of kernels code uses, which of them the cache lacks, and processes for these.

`riot.kernels.warm` is what others call. A command whose kernels are in the cache loads neither Numba nor what starts
processes (tests/unit/test_compiling.py).
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

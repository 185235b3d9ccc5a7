"""Numba kernels: functions of plain arrays, one module for each hot loop; geometry, policy and files stay outside.

Fast mathematics are off (`options`), so that the same input gives the same bits in every process. The function ``warm``
of a module compiles its kernels, and an edit makes them compile again: README.md says what may be changed
(tests/unit/test_kernels.py).
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

"""From a transform to a puzzle in the hand: hinges, solids, certificate, files to print and cut (paper §4.4).

All lengths are in millimetres. A puzzle is certified to fit together and to move before it is written; what cannot be
built raises `FabricationError`, which names the parameter to change (tests/property/test_fabrication.py).
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

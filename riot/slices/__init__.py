"""Objects in the round as stacks of thick slices, each a puzzle that becomes another shape (paper Fig. 20). In mm.

A model is cut into slices, each slice is assigned a shape that it turns into, and each pair is constructed and built
as any other. Models come from files that nobody vouches for; `ModelError` says what is wrong
(tests/property/test_slices.py, tests/unit/test_models.py).
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

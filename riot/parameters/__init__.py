"""Every parameter with its default, range, unit, meaning and source: one module a group, and the one home of defaults.

A group is checked when it is made, in the library as in the pipeline, and nothing here computes a result or loads a
numeric library (tests/unit/test_parameters.py, test_faces.py).
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

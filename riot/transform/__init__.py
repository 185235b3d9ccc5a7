"""A transform as data, with what can be read off it: poses, certificate, fidelity, the ``.riot`` file (paper §3.1).

`riot.transform.transform.Transform` and `riot.transform.motion.Motion` hold values and compute poses from them;
everything else is a function. Nothing here plans, draws or constructs; a file reads back equal to the last bit
(tests/unit/test_transform.py, tests/property/test_fidelity.py, test_centreline.py).
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

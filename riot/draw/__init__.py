"""Pictures of a transform: one figure or a strip of its motion (SVG, PNG, PDF), animated SVG, film.

The same transform gives the same bytes. Pictures change no result: nothing below imports this package, so that no
score is computed again when a colour changes (tests/unit/test_draw.py, tests/unit/test_layers.py).
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

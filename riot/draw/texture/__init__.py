"""Textures of the pieces: the two inputs' own pictures, or patterns, warped onto the dissections.

`names` says what sides and patterns are called and imports nothing; `warp` moves a picture with its shape, `paint` and
`sample` put it on the pieces (tests/property/test_texture.py, tests/unit/test_piece_images.py).
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

"""The front door: the command ``riot`` over a mined collection, and what is said on the terminal."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

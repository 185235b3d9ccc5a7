"""A run's tables: their schemas, how they are written, and the record of the run."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

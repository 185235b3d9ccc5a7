"""From pictures, vector files and polygons to shapes (paper §6).

A `riot.geometry.shape.Shape` is data; the readers in `silhouette` make it from untrusted files. `limits` bounds the
length of a file, and a refused file raises `SilhouetteError`. A shape does not depend on the rotation,
position, size or first vertex of its outline (tests/property/test_silhouette_properties.py,
tests/fuzz/test_readers.py).
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

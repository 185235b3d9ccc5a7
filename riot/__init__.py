"""RIOT: pairs of silhouettes that turn inside out into each other, and the pieces that do it.

>>> from riot import Shape, construct, crs, qcrs, reversibility, trunks

A `Shape` is read from a picture, a vector file or a polygon; `reversibility`, `qcrs` and `crs` score one shape or
two; `trunks` lists the convex polygons on which a dissection may rest; `construct` cuts the pieces and returns a
`Transform`. Its packages stand in layers, each of which imports only those below it (tests/unit/test_layers.py).
Importing ``riot`` loads none of them: each loads when it is first used (tests/unit/test_faces.py).
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

"""RIOT: pairs of silhouettes that turn inside out into each other, and the pieces that do it.

>>> from riot import Shape, construct, crs, qcrs, reversibility, trunks

A `Shape` is read from a picture, a vector file or a polygon; `reversibility`, `qcrs` and `crs` score one shape or
two; `trunks` lists the convex polygons on which a dissection may rest; `construct` cuts the pieces and returns a
`Transform`.
"""

from types import ModuleType
from typing import TYPE_CHECKING

from riot.lazy import offer

if TYPE_CHECKING:
    from riot.offered import *  # noqa: F403


def _offered() -> ModuleType:
    import riot.offered as module

    return module


offer(__name__, _offered, ("construct", "reversibility", "trunks"))

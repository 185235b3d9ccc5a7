"""Find which triangle is nearest to the eye at every pixel. Ours.

Every triangle is cut into rows of pixels, and of all that fall on a pixel the nearest stays. Sums and products only, in
a fixed order, so that a picture has the same bytes on any machine.
"""

from __future__ import annotations

import numpy as np

from riot.kernels.depth import nearest
from riot.types import FloatArray, IntArray


def nearest_triangles(corners: FloatArray, rows: int, columns: int) -> IntArray:
    """(rows, columns) which of the triangles (f, 3, 3) is seen at each pixel's middle, −1 for none.

    ``corners`` are columns, rows, and how near; a triangle that is clockwise is seen from behind, and not drawn. Of
    triangles that are equally near, the first is seen.

    >>> triangle = np.array([[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]])
    >>> nearest_triangles(triangle, 4, 5)[1].tolist()
    [0, 0, 0, -1, -1]
    """
    found: IntArray = nearest(np.array(corners, dtype=np.float64), rows, columns)
    return found

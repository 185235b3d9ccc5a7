from . import conjugate_polygons as conjugate_polygons
from . import limits as limits
from . import pairs as pairs
from . import tree as tree

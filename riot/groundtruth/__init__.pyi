from . import pairs as pairs
from . import tree as tree

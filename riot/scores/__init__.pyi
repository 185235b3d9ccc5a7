from . import convexity as convexity
from . import crs as crs
from . import index as index
from . import leaves as leaves
from . import qcrs as qcrs
from . import reversibility as reversibility
from . import trunks as trunks
from . import vertices as vertices

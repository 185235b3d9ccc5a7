from . import compiling as compiling
from . import simplify as simplify
from . import warm as warm

from . import consistency as consistency
from . import distributions as distributions
from . import groundtruth as groundtruth
from . import make as make
from . import parameters as parameters
from . import quiz as quiz
from . import sigmas as sigmas
from . import timing as timing

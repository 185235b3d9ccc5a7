from . import certificate as certificate
from . import fidelity as fidelity
from . import history as history
from . import motion as motion
from . import motion_document as motion_document
from . import pose as pose
from . import riot_file as riot_file
from . import transform as transform

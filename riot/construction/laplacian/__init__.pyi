from . import contact as contact
from . import editing as editing
from . import method as method
from . import phases as phases
from . import residual as residual
from .method import construct_laplacian as construct_laplacian

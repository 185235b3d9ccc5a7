from . import cache as cache
from . import compilation as compilation
from . import process as process
from . import uses as uses
from . import waiting as waiting

from . import schemas as schemas
from . import sweep as sweep
from . import write as write

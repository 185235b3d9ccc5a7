from . import progress as progress
from . import summary as summary

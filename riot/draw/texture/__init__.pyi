from . import names as names
from . import outline_match as outline_match
from . import paint as paint
from . import sample as sample
from . import source as source
from . import triangulation as triangulation
from . import tuning as tuning
from . import warp as warp

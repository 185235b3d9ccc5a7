from . import names as names
from . import paint as paint
from . import sample as sample
from . import source as source
from . import warp as warp

from . import names as names
from . import paint as paint
from . import skins as skins
from . import source as source
from . import warp as warp

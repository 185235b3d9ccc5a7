from . import flat as flat
from . import folder as folder
from . import page as page
from . import paper as paper
from . import paperwork as paperwork
from . import picture as picture
from . import sheets as sheets
from . import solids as solids

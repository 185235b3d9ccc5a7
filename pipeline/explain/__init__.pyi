from . import causes as causes
from . import forecast as forecast
from . import show as show

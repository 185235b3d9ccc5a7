from . import completion as completion
from . import coupon as coupon
from . import make as make
from . import print_puzzle as print_puzzle
from . import show as show
from . import slices as slices
from . import trunks as trunks

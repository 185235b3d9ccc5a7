from . import check as check
from . import comparison as comparison
from . import write as write
from .assets import assets_digest as assets_digest
from .write import write_report as write_report

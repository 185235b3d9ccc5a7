"""The report of a finished run, one HTML page that needs nothing but itself, and the gallery of its transforms.

Everything here only reads a run's folder; no result depends on it (tests/integration/test_report.py, test_gallery.py).
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

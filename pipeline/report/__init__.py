"""The report of a finished run, one HTML page that needs nothing but itself, and the gallery of its transforms.

Everything here only reads a run's folder; no result depends on it. Rows of tables become frozen view models, and
templates (``templates/``, ``static/``) make pages of these. The same run gives the same bytes, all text is escaped, and
the pages work without script (tests/integration/test_report.py, test_gallery.py). `assets_digest` stands for the
templates where the look of a page is part of a digest.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

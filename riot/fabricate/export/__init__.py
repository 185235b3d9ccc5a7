"""The files of a puzzle: solids to print (STL, 3MF), flat pieces to cut (SVG, DXF), paper (PDF), pictures, a page.

The same design gives the same bytes. A folder is written whole or not at all: `folder` refuses one that is in use
(tests/unit/test_fabrication_files.py, test_flat_files.py, test_paper_files.py).
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

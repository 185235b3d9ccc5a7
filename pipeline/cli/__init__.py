"""The command line: ``riot`` over a mined collection, ``pipeline.cache``, and what a run prints on the terminal.

Commands parse arguments, call the packages below, and print; no result depends on them. Exit codes and messages must
say what to do next (tests/integration/test_match.py, tests/unit/test_cache_command.py, test_cache_under_edits.py).
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

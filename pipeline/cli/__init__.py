"""The command line: the program ``riot`` with all its commands, and what a run prints on the terminal.

Commands parse arguments, call the packages below, and print; no result depends on them. Each is loaded when it is
called. Exit codes and messages must say what to do next (tests/unit/test_front_door.py, test_cache_command.py,
tests/integration/test_match.py).
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

"""The command line: make, show, trunks, print, coupon and slices, and what every command stands on.

A command is a module with `add_options` and `run`: it reads files, calls the library, prints facts through one
`riot.cli.output.Output`, and computes nothing itself. It is loaded when it is called. What the user can mend ends with
a message and exit code 2 (tests/unit/test_front_door.py, test_transform.py, test_fabrication_files.py).
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

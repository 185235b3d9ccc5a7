"""The tables of a run: their schemas, how they are written, and the record of the run (``run.json``).

A stage says in its own file which columns it adds; here are the columns that a table has by itself, and the code that
joins them. Equal runs must write equal bytes, and a run's folder must never hold a table that is half written
(tests/integration/test_run.py, test_sweep.py; tests/chaos).
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

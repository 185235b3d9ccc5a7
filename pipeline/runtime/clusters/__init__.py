"""Clusters: where tasks run. `open_cluster` opens any of them, each kind has a file, and all write the same bytes.

A kind yields an `Executor`. What a new kind must hold: tests/unit/test_execute.py for executors,
tests/integration/test_external_cluster.py and test_slurm.py for workers that come, go and are refused.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

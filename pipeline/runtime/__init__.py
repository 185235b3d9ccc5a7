"""Where the work is done: clusters, workers, retries, quarantine, and what a run tells while it runs.

Every cluster writes the same bytes. Deadly work is found and set aside, and all else comes out as without it
(tests/integration/test_external_cluster.py, test_poisoned_run.py, tests/chaos).
"""

"""Content-addressed artifacts, in a folder or on an object store: what a key is made of, and what it names.

The payload is written first, the manifest last: the manifest is the commit. Whatever is torn or altered is a miss
(tests/property/test_store.py, tests/stores, tests/chaos).
"""

"""The commands of two files: make, show, trunks, print, slices.

A command reads files, calls the library, prints numbers and writes results; it computes nothing itself. What the user
can mend ends with a message and exit code 2 (tests/unit/test_transform.py, tests/unit/test_fabrication_files.py,
tests/integration/test_slice_sets.py).
"""

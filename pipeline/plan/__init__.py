"""Which work a run consists of: work items, sub-blocks, batches, and the digests of the code that does the work.

`Progress` is what a run knows between two stages; nothing in it changes. A digest holds what a stage's work reaches,
and nothing that plans or shows it (tests/unit/test_code_digest.py, tests/property/test_edits.py).
"""

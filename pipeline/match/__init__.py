"""Search a mined collection for the best partners of a new shape, or of the slices of a solid.

Nothing here computes a stage: the search reads the artifacts of a finished run, refuses those of other code, and keeps
its index in the store. A search must return the scores of a run over all pairs (tests/integration/test_match.py).
"""

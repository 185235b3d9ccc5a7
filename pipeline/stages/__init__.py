"""The stages' work: one module each, from input artifacts to an output artifact.

A module here sees artifacts, parameters and a small specification: no store, no paths of a run, no cluster. Its import
closure is the code digest of its stage, so nothing else belongs in it.
"""

"""A piece of work as a history of immutable states, and its folder on disk; no web, no geometry.

A state names shapes and transforms by digest: the folder keeps each once, so that undoing computes nothing.
"""

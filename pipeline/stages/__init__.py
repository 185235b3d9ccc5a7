"""The stages of the method, a file each: what it reads, how its work is planned and done, what the tables show of it.

A module of this package that defines ``STAGE`` is a stage; its place follows from the stages that it comes ``after``.
Modules here are loaded to plan a run, so that they name what computes by the faces of `riot`, which load it at first
use. What ``run`` reaches is the code that enters a stage's keys; what plans is not (tests/unit/test_code_digest.py).
"""

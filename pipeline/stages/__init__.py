"""The stages of the method, a file each: what a stage reads, how its work is planned and done, and what tables show.

A module of this package that defines ``STAGE`` is a stage; the stages that it comes ``after`` decide the order. These
modules are loaded to plan a run: they call what computes through the faces of `riot`, which load it at first use. The
code that a stage's ``run`` reaches enters its keys; the code that plans does not (tests/unit/test_code_digest.py).
"""

"""The configuration of a run: `schema.py` declares every parameter for Hydra, `--help` and the guide.

`conf/` holds choices, and of them only what differs from the schema's defaults (tests/unit/test_conf_files.py). Every
mistake of a command line is found before any work, in a message that names what is allowed (test_config.py).
"""

"""The configuration of a run: its schema, and the command line that fills it."""

"""Exit codes of a run."""

CLEAN, FAILED, BAD_START, WITH_ERRORS, INTERRUPTED = 0, 1, 2, 3, 130
"""All well; broke off or had to stop; could not start; finished, with rows in the table of errors; interrupted."""

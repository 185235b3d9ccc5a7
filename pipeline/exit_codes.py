"""Exit codes of a run."""

CLEAN, FAILED, BAD_START, WITH_ERRORS, INTERRUPTED = 0, 1, 2, 3, 130

MEANINGS = {
    CLEAN: "The run is finished, without errors.",
    FAILED: "It had to stop: a full disk, a failing machine, an unexpected error. The same command goes on from there.",
    BAD_START: "It could not start: a wrong name or value, no pictures, no worker.",
    WITH_ERRORS: "It is finished, and each error is a row of the table errors (identical files are no error).",
    INTERRUPTED: "It was interrupted. The same command goes on from there.",
}
"""What each code means; of a sweep the greatest code of its jobs counts."""

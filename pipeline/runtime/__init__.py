"""Where the work is done: clusters, workers, retries, quarantine, and what a run tells."""

"""A run's tables: their schemas, how they are written, and the record of the run."""

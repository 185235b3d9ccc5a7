"""Which work a run consists of: work items, content keys, code digests, explanations."""

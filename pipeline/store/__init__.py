"""Content-addressed artifacts on a folder or an object store."""

from pipeline.plan import sources as _sources  # noqa: F401  (before any other module of the project is loaded)

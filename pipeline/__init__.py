"""The dataflow that mines a collection: which silhouettes, which work, where it is done, and what comes out.

`riot` is the geometry and knows nothing of this package. Layers, from the bottom: store, datasets, config, plan,
stages, explain, runtime, tables, then report, study and match, and at the top the entry points.
"""

import lazy_loader

from pipeline.plan import sources as _sources  # noqa: F401  (before any other module of the project is loaded)

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

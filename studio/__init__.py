"""The studio: work on a transform in the browser, served on this machine (`riot studio`).

`session` is the history of a piece of work, pure; `work` computes answers in processes of their own; `server` speaks
with browsers, in the messages of `messages`; `static` is the page. Geometry stays in `riot`, the mined collection in
`pipeline` (tests/unit/test_studio_session.py, tests/integration/test_studio_server.py).
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

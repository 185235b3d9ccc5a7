"""Studies of a finished run: what its tables say about the method, as a table, figures and a page of each.

Each study is a module with ``Parameters`` and ``study``; `pipeline.study.registry` lists them, and a module is loaded
when its study is asked for. Equal runs give equal tables and pages: what varies, such as times, lies in files of its
own (tests/integration/test_studies.py, test_quiz.py).
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

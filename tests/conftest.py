"""What all tests share: compiled kernels."""

from __future__ import annotations

import pytest

from riot.kernels.warm import uncompiled, warm_all


def pytest_collection_finish(session: pytest.Session) -> None:
    """Compile the numeric kernels where they are not: that takes minutes, which are no single test's."""
    if session.items and not session.config.getoption("collectonly") and uncompiled():
        warm_all(lambda message: session.config.get_terminal_writer().line(message))

"""The error of solids that cannot be cut into slices. Ours."""

from __future__ import annotations

from riot.errors import RiotError


class ModelError(RiotError, ValueError):
    """A solid that cannot be read, or not be cut as asked.

    ``reason`` is one short word for tables; the message says what is wrong, where, and what to do.
    """

    def __init__(self, reason: str, message: str) -> None:
        super().__init__(message)
        self.reason = reason

    def __reduce__(self) -> tuple[type[ModelError], tuple[str, str]]:
        return type(self), (self.reason, str(self))

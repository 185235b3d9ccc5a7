"""The error of fabrication. Ours."""

from __future__ import annotations

from riot.errors import RiotError


class FabricationError(RiotError, ValueError):
    """A puzzle that cannot be made as asked.

    ``reason`` is one short word for tables; ``parameter`` names the parameter that would mend it, empty if none
    would; ``value`` is the least (or greatest) value of it that might, NaN if that is not known.
    """

    def __init__(self, reason: str, message: str, parameter: str = "", value: float = float("nan")) -> None:
        super().__init__(message)
        self.reason = reason
        self.parameter = parameter
        self.value = value

    def __reduce__(self) -> tuple[type[FabricationError], tuple[str, str, str, float]]:
        return type(self), (self.reason, str(self), self.parameter, self.value)

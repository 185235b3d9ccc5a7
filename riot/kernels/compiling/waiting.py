"""How far the kernels are that something waits for."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Waiting:
    """Of ``total`` modules that something waits for ``done`` are compiled.

    ``seconds`` is an estimate of the time that remains, from the modules that are compiled; None before the first is.
    """

    done: int
    total: int
    seconds: float | None

    def __str__(self) -> str:
        """Such as ``3 of 14 modules, about 25 s remain``.

        >>> str(Waiting(3, 14, 24.6)), str(Waiting(0, 1, None))
        ('3 of 14 modules, about 25 s remain', '0 of 1 modules')
        """
        remaining = "" if self.seconds is None else f", about {max(1, round(self.seconds))} s remain"
        return f"{self.done} of {self.total} modules{remaining}"

"""The errors of the library: one root, and a builtin parent each, so that both kinds of handler work."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any

DISTRIBUTION = "riot-shapes"
"""What pip installs."""


class RiotError(Exception):
    """Root of every error that this project raises on purpose."""


class ParameterError(RiotError, ValueError):
    """A value that a parameter cannot take; the message names the parameter, what is allowed, and the value given."""

    def __init__(self, parameter: str, message: str) -> None:
        super().__init__(f"{parameter}: {message}")
        self.parameter = parameter
        self.message = message

    def __reduce__(self) -> tuple[type[ParameterError], tuple[str, str]]:
        return type(self), (self.parameter, self.message)


class SilhouetteError(RiotError, ValueError):
    """A picture, vector file or polygon that cannot become a shape.

    ``reason`` is one short word for tables (``"unreadable"``, ``"one-colour"``, ``"degenerate"`` …);
    the message says what is wrong, where, and what to do.
    """

    def __init__(self, reason: str, message: str) -> None:
        super().__init__(message)
        self.reason = reason

    def __reduce__(self) -> tuple[type[SilhouetteError], tuple[str, str]]:
        return type(self), (self.reason, str(self))


class TrunkError(RiotError, ValueError):
    """Trunks that are missing, or given trunks that are not convex, not conjugate or not on the outline."""


class ConstructionError(RiotError, ValueError):
    """A pair of trunks from which no exact transform could be constructed; ``reason`` is one word."""

    def __init__(self, reason: str, message: str) -> None:
        super().__init__(message)
        self.reason = reason

    def __reduce__(self) -> tuple[type[ConstructionError], tuple[str, str]]:
        return type(self), (self.reason, str(self))


class PinError(ConstructionError):
    """A pin that cannot be met; its ``reason`` is ``pins``.

    ``pin`` is its number among those of its shape, ``points`` (k, 2) where it is in the shape's frame, and ``side`` the
    shape, "p" or "q"; None, empty and "" if it is no single one.
    """

    def __init__(
        self, message: str, pin: int | None = None, points: tuple[tuple[float, float], ...] = (), side: str = ""
    ) -> None:
        super().__init__("pins", message)
        self.pin, self.points, self.side = pin, points, side

    def of(self, pin: int, points: Iterable[Iterable[float]]) -> PinError:
        """The same error, of the pin with this number, which is at ``points`` if no place is known yet."""
        return PinError(str(self), pin, self.points or self.at(points).points, self.side)

    def at(self, points: Iterable[Iterable[float]]) -> PinError:
        """The same error, at ``points``."""
        return PinError(str(self), self.pin, tuple((float(x), float(y)) for x, y in points), self.side)

    def on(self, side: str) -> PinError:
        """The same error, of the shape "p" or "q"."""
        return PinError(str(self), self.pin, self.points, side)

    def __reduce__(self) -> tuple[type[PinError], tuple[Any, ...]]:
        return type(self), (str(self), self.pin, self.points, self.side)


class FormatError(RiotError, ValueError):
    """A file that claims to be ours and is not: another format, another version, or damaged."""


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


class MissingExtraError(RiotError, ModuleNotFoundError):
    """A package that is not installed, and that an extra of this project brings: ``extra`` is the name of the extra."""

    def __init__(self, package: str, extra: str) -> None:
        super().__init__(
            f"this needs the package {package}, which is not installed: pip install '{DISTRIBUTION}[{extra}]'",
            name=package,
        )
        self.package = package
        self.extra = extra

    def __reduce__(self) -> tuple[type[MissingExtraError], tuple[str, str]]:
        return type(self), (self.package, self.extra)


@contextmanager
def needs_extra(name: str) -> Iterator[None]:
    """Say which extra to install if an import inside fails: raises `MissingExtraError`.

    >>> with needs_extra("film"):
    ...     import no_such_package
    Traceback (most recent call last):
    riot.errors.MissingExtraError: this needs the package no_such_package, which is not installed: \
pip install 'riot-shapes[film]'
    """
    try:
        yield
    except MissingExtraError:
        raise
    except ModuleNotFoundError as error:
        raise MissingExtraError((error.name or "").partition(".")[0], name) from error


class ModelError(RiotError, ValueError):
    """A solid that cannot be read, or not be cut as asked.

    ``reason`` is one short word for tables; the message says what is wrong, where, and what to do.
    """

    def __init__(self, reason: str, message: str) -> None:
        super().__init__(message)
        self.reason = reason

    def __reduce__(self) -> tuple[type[ModelError], tuple[str, str]]:
        return type(self), (self.reason, str(self))

"""Locations: where a store, a run's tables or a data set is, in a folder or on an object store."""

from __future__ import annotations

from pathlib import Path


class Url(str):
    """A location on an object store that fsspec knows, such as ``s3://bucket/prefix``; each has one spelling."""

    __slots__ = ()

    TYPE_NAME = "a URL"
    """What messages and the table of parameters call it."""

    def __new__(cls, text: str) -> Url:
        """Raises ValueError for text that is no URL."""
        scheme, separator, rest = text.partition("://")
        if not (scheme.isalnum() and separator and rest.strip("/")):
            raise ValueError(f"{text!r} is no URL; give PROTOCOL://LOCATION, such as s3://bucket/prefix")
        return super().__new__(cls, f"{scheme}://{rest.strip('/')}")

    def joinpath(self, *names: str) -> Url:
        """The location below this one."""
        return Url("/".join([self, *names]))


Location = Path | Url


def parse_location(text: str | Path) -> Location:
    """A `Url` if the text is one, else a path.

    >>> parse_location("s3://bucket/prefix/")
    's3://bucket/prefix'
    >>> parse_location("store").name
    'store'
    """
    return Url(text) if isinstance(text, str) and "://" in text else Path(text)

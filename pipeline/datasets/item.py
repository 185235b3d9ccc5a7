"""One silhouette of a collection: its name, its class, and where it is read from."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import PurePath

SOURCE = "{source}"
"""Replaces an item's path in stored messages, so that they do not depend on the collection's folder."""

SAMPLE_PREFIX = "sample:"
"""Begins the source of an item of the embedded sample."""


@dataclass(frozen=True)
class Item:
    """One silhouette to be read.

    ``name`` is unique in its collection (the path below the root, without suffix); ``cls`` its class, ``""`` for
    none; ``source`` the file, or ``sample:<name>``; ``digest`` the SHA-256, in hex, of the file's bytes or of the
    sample's definition.
    """

    name: str
    cls: str
    source: str
    digest: str

    @property
    def shown_source(self) -> str:
        """See `shown_source`."""
        return shown_source(self.name, self.source)


def shown_source(name: str, source: str) -> str:
    """A source without the folder of its collection: a sample's definition, or the file's path below the root.

    >>> shown_source("fish-1", "/pictures/fish-1.png")
    'fish-1.png'
    """
    if source.startswith(SAMPLE_PREFIX):
        return source
    suffix = PurePath(source).suffix
    return name if name.endswith(suffix) else name + suffix

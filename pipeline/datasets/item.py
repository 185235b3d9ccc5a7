"""One silhouette of a collection and how it is opened, apart from how collections are listed.

Ingest runs this module and not the listing, so that a change of how folders are listed leaves every artifact alone.
"""

from __future__ import annotations

from dataclasses import dataclass

from pipeline.datasets import sample
from riot.geometry.shape import Shape
from riot.parameters import ShapeParameters

SOURCE = "{source}"
"""Stands for an item's source in kept messages: where a collection lies is no part of its content."""


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


def open_item(item: Item, parameters: ShapeParameters | None = None) -> Shape:
    """Read an item's silhouette; raises `riot.errors.SilhouetteError`."""
    from riot.geometry.silhouette import read  # here, so that a collection is listed without what reads pictures

    if item.source.startswith(sample.PREFIX):
        return sample.shape(item.source, parameters).renamed(item.name)
    return read(item.source, parameters).renamed(item.name)

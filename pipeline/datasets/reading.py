"""Read the silhouette of an item.

The stage ingest runs this module and not `collection`: an edit of how folders are listed changes no key.
"""

from __future__ import annotations

from pipeline.datasets import sample
from pipeline.datasets.item import SAMPLE_PREFIX, Item
from riot import geometry
from riot.geometry.shape import Shape
from riot.parameters import ShapeParameters


def open_item(item: Item, parameters: ShapeParameters | None = None) -> Shape:
    """Read an item's silhouette; raises `riot.errors.SilhouetteError`."""
    if item.source.startswith(SAMPLE_PREFIX):
        return sample.shape(item.source, parameters).renamed(item.name)
    return geometry.silhouette.read(item.source, parameters).renamed(item.name)

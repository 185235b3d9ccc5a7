"""Which pictures of a collection may have colours to show on the pieces."""

from __future__ import annotations

from PIL import Image

from pipeline.datasets.item import SAMPLE_PREFIX, Item
from riot.geometry.picture import PICTURE_FORMATS


def may_be_coloured(item: Item) -> bool:
    """Whether the header of an item's file says that it can be transparent; False if the file cannot be opened."""
    if item.source.startswith(SAMPLE_PREFIX):
        return False
    try:
        with Image.open(item.source, formats=PICTURE_FORMATS) as image:
            return "A" in image.getbands() or "transparency" in image.info
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError):  # ingest reports such a file
        return False

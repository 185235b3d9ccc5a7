"""Whether a picture's opacity tells an object from a page, and the picture on its page where it does not (ours)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from PIL import Image

from riot.types import BoolArray

_CORNERS = 0.04
"""A page whose transparent part is at most this share of it may have rounded corners, or specks. Ours: the corners of
a card have about this share at a radius of a fifth of its side."""

_PAGE_BORDER = 0.55
"""Share of the border that is opaque in such a page. Ours."""

_SAME_COLOUR = 24
"""Channels that differ by at most this, of 255, are of one colour. Ours: above the noise of a camera or of JPEG."""

_LEAST_SHOWN = 0.005
"""Least share of a page that shows something. Ours."""


def opacity_separates(image: Image.Image) -> bool:
    """Whether the opacity of an RGBA picture tells an object from its page.

    It does not if all is about as opaque and shows something by its colours, or if it only rounds the corners of a
    page, or leaves specks on it, that does.

    >>> page = Image.new("RGBA", (20, 20), (255, 255, 255, 255))
    >>> page.paste((0, 0, 0, 255), (5, 5, 15, 15))
    >>> page.putpixel((3, 3), (255, 255, 255, 254))
    >>> opacity_separates(page)
    False
    """
    opacity = np.asarray(image.getchannel("A"))
    least, most = int(opacity.min()), int(opacity.max())
    colours = np.asarray(image)[..., :3]
    if 2 * least >= most:
        return least < most and not np.ptp(colours, axis=(0, 1)).any()
    opaque = 2 * opacity.astype(np.int16) > least + most
    share = float((~opaque).sum()) / opaque.size
    if share > _CORNERS or _border(opaque).mean() < _PAGE_BORDER:
        return True
    difference = np.abs(colours[opaque].astype(np.int16) - page_colour(colours, opaque).astype(np.int16))
    return bool((difference.max(axis=1) <= _SAME_COLOUR).mean() > 1.0 - _LEAST_SHOWN)


def over_page(image: Image.Image) -> Image.Image:
    """An RGBA picture on a page of the colour that the opaque part of its border has; RGB.

    >>> over_page(Image.new("RGBA", (2, 2), (9, 8, 7, 255))).getpixel((0, 0))
    (9, 8, 7)
    """
    values = np.asarray(image)
    opaque = values[..., 3] >= 128
    page = (255, 255, 255)
    if _border(opaque).any():
        red, green, blue = (int(channel) for channel in page_colour(values[..., :3], opaque))
        page = (red, green, blue)
    under = Image.new("RGBA", image.size, (*page, 255))
    return Image.alpha_composite(under, image).convert("RGB")


def page_colour(colours: npt.NDArray[np.uint8], opaque: BoolArray) -> npt.NDArray[np.uint8]:
    """(3,) uint8 the median colour of the opaque border pixels."""
    rim = np.concatenate([colours[0], colours[-1], colours[1:-1, 0], colours[1:-1, -1]])
    return np.asarray(np.median(rim[_border(opaque)], axis=0).astype(np.uint8))


def _border(mask: BoolArray) -> BoolArray:
    return np.concatenate([mask[0], mask[-1], mask[1:-1, 0], mask[1:-1, -1]])

"""Pixels in memory, arrays and Pillow images, → Shape. Ours."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image

from riot.errors import SilhouetteError
from riot.geometry.machine_errors import is_of_machine
from riot.geometry.picture import grey_picture
from riot.geometry.shape import Shape
from riot.geometry.silhouette import mask_shape, picture_shape
from riot.parameters import ShapeParameters

CHANNELS = (1, 2, 3, 4)
"""Of a three-dimensional array: grey, grey and opacity, RGB, RGB and opacity."""


def pixels_shape(
    pixels: npt.ArrayLike | Image.Image, name: str = "", parameters: ShapeParameters | None = None
) -> Shape:
    """Make a shape of the object in pixels; polarity, holes and coordinates as `riot.geometry.silhouette.read_image`.

    Parameters
    ----------
    pixels : array or PIL.Image.Image
        (rows, columns) booleans or grey values, or (rows, columns, channels) booleans, uint8, or floats in [0, 1]:
        grey, grey and opacity, RGB, or RGB and opacity. Row 0 is on top.
    name : str
        Of the shape; by default the name of the file from which Pillow opened the image.
    parameters : ShapeParameters, optional

    Raises
    ------
    SilhouetteError
        ``unreadable`` (neither of these), and as `read_image`.

    >>> rows, columns = np.mgrid[-20:21, -20:21]
    >>> disc = np.hypot(rows, columns) < 15
    >>> pixels_shape(disc, "disc") == pixels_shape(Image.fromarray(disc), "disc")
    True
    """
    chosen = parameters or ShapeParameters()
    if isinstance(pixels, Image.Image):
        return _image_shape(pixels, name or Path(getattr(pixels, "filename", "")).stem, "the image", chosen)
    where = name or "the array"
    try:
        values = np.asarray(pixels)
    except ValueError as error:
        raise SilhouetteError("unreadable", f"{where}: the rows differ in length") from error
    _refuse_large(values.shape, where, chosen.max_pixels)
    if values.ndim == 3 and values.shape[2] == 1:
        values = values[:, :, 0]
    if values.ndim == 3 and values.shape[2] in CHANNELS and values.size:
        return _image_shape(Image.fromarray(_bytes(values, where)), name, where, chosen)
    if values.ndim != 2:
        raise SilhouetteError(
            "unreadable",
            f"{where}: a picture is (rows, columns) or (rows, columns, channels) with 1 to 4 channels, not "
            f"{values.shape}",
        )
    return mask_shape(values, name, chosen)


def _image_shape(image: Image.Image, name: str, where: str, parameters: ShapeParameters) -> Shape:
    where = name or where
    _refuse_large((image.height, image.width), where, parameters.max_pixels)
    try:
        image.load()
        picture = grey_picture(image)
    except Exception as error:  # decoders raise nearly anything on damaged files
        if is_of_machine(error):
            raise
        raise SilhouetteError("unreadable", f"{where}: the image cannot be decoded ({error!r})") from error
    return picture_shape(picture, name, where, parameters)


def _refuse_large(size: tuple[int, ...], where: str, max_pixels: int) -> None:
    pixels = int(np.prod(size[:2]))
    if pixels > max_pixels:
        raise SilhouetteError(
            "too-large",
            f"{where}: {pixels} pixels are more than the limit of {max_pixels}; scale it down or raise max_pixels",
        )


def _bytes(values: npt.NDArray[np.generic], where: str) -> npt.NDArray[np.uint8]:
    """Channels as Pillow takes them."""
    if values.dtype == np.uint8:
        return np.ascontiguousarray(values, dtype=np.uint8)
    if values.dtype.kind in "bf":
        numbers = values.astype(np.float64)
        if ((numbers >= 0.0) & (numbers <= 1.0)).all():
            return np.rint(numbers * 255.0).astype(np.uint8)
    raise SilhouetteError(
        "unreadable", f"{where}: channels are booleans, uint8 or floats from 0 to 1, not {values.dtype} beyond them"
    )

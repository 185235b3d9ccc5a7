"""Picture files → grey values and colours, refusing early what is no picture or too big to decode."""

from __future__ import annotations

import os
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import ExifTags, Image, ImageChops, ImageOps, UnidentifiedImageError, features

from riot.errors import SilhouetteError
from riot.geometry.limits import PICTURE_BYTES, TooManyBytes, check_file
from riot.geometry.machine_errors import is_of_machine
from riot.geometry.opacity import opacity_separates, over_page
from riot.types import FloatArray

_OPTIONAL = tuple(name for name in ("WEBP", "AVIF") if features.check(name.lower()))
"""Formats that Pillow reads where it was built with their libraries, as its wheels are."""

PICTURE_FORMATS = ("PNG", "GIF", "BMP", "TIFF", "JPEG", *_OPTIONAL)
"""The decoders that may run: Pillow has others that would start foreign programs."""

PICTURE_SUFFIXES = (".png", ".gif", ".bmp", ".tif", ".tiff", ".jpg", ".jpeg", ".webp", ".avif")

WORKING_SIDE = 2048
"""Pictures with a longer side are averaged down to it; boundary points are some hundred times coarser."""

_NUMBERS = ("I", "F", "I;16", "I;16L", "I;16B")
"""Modes of Pillow with grey values beyond 0 … 255."""

_GREYS = ("1", "L")
"""Modes of Pillow that have no colour."""


@dataclass(frozen=True, eq=False)
class Picture:
    """A decoded picture.

    Parameters
    ----------
    grey : (rows, columns) float64
        0 (dark) … 255 (light), or the opacity where ``opaque_object``.
    opaque_object : bool
        The picture has transparent and opaque parts: the object is the opaque part, whatever its colours.
    factor : int
        Each value is the mean of ``factor × factor`` pixels of the file.
    colours : (rows, columns, 3) uint8, optional
        Red, green and blue; None where all pixels are grey, or opacity decides.
    """

    grey: FloatArray
    opaque_object: bool
    factor: int
    colours: npt.NDArray[np.uint8] | None = None


def decode(path: str | os.PathLike[str], max_pixels: int) -> Picture:
    """Decode the (first) picture in a file of one of `PICTURE_FORMATS`, whatever its suffix says.

    The size is checked in the header, before any pixel is decoded; of many pictures or frames only the first is.
    Pixels are turned as the file's orientation tag (EXIF) says, as every viewer does.

    Raises
    ------
    SilhouetteError
        ``unreadable`` (missing, no permission, truncated, damaged), ``not-a-picture``, ``too-large``.
    MemoryError, OSError
        The machine failed (`riot.geometry.machine_errors`): nothing is known of the file.
    """
    where = Path(path)
    try:
        check_file(where, PICTURE_BYTES)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # max_pixels decides, and a damaged file is an error or a shape
            with Image.open(where, formats=PICTURE_FORMATS) as image:
                if image.width * image.height > max_pixels:
                    raise SilhouetteError(
                        "too-large",
                        f"{where}: {image.width} × {image.height} pixels are more than max_pixels, {max_pixels}; "
                        "scale the picture down",
                    )
                image.load()
                if not image.width * image.height:
                    raise _damaged(where, ValueError("no pixels"))
                return grey_picture(upright(image))
    except SilhouetteError:
        raise
    except UnidentifiedImageError as error:
        raise SilhouetteError(
            "not-a-picture",
            f"{where}: the content is none of {', '.join(PICTURE_FORMATS)}; convert it to PNG, or remove the file",
        ) from error
    except (Image.DecompressionBombError, TooManyBytes) as error:
        raise SilhouetteError("too-large", f"{where}: {error}; scale the picture down") from error
    except Exception as error:  # decoders raise nearly anything on damaged files
        if is_of_machine(error):
            raise
        if isinstance(error, OSError) and error.strerror is not None:  # Pillow's own, of damaged files, have none
            message = f"{where}: cannot be read ({error.strerror}); check the path"
            raise SilhouetteError("unreadable", message) from error
        raise _damaged(where, error) from error


def upright(image: Image.Image) -> Image.Image:
    """A loaded picture turned as its orientation tag says; a broken tag says nothing.

    >>> upright(Image.new("L", (4, 3))).size
    (4, 3)
    """
    try:
        if image.getexif().get(ExifTags.Base.Orientation, 1) == 1:
            return image
        turned = ImageOps.exif_transpose(image)
    except Exception as error:  # a tag may hold anything
        if is_of_machine(error):
            raise
        return image
    return turned


def _damaged(where: Path, error: Exception) -> SilhouetteError:
    reason = (str(error).splitlines() or [type(error).__name__])[0]
    return SilhouetteError("unreadable", f"{where}: cannot be read ({reason}); restore the file or save it again")


def grey_picture(image: Image.Image) -> Picture:
    """A loaded Pillow image as grey values and colours or, where its opacity tells an object from a page, as opacity.

    >>> grey_picture(Image.new("L", (4, 3), 7)).grey.shape
    (3, 4)
    """
    factor = max(1, -(-max(image.size) // WORKING_SIDE))
    if image.mode in _NUMBERS:
        values = np.asarray(image, dtype=np.float64)
        values = np.nan_to_num(values, nan=0.0, posinf=0.0, neginf=0.0)
        low, high = float(values.min()), float(values.max())
        if high > low:
            values = (values - low) * (255.0 / (high - low))
        return Picture(values if factor == 1 else _block_mean(values, factor), False, factor)
    if "A" in image.getbands() or "transparency" in image.info:
        # Premultiplied modes have no direct way to RGBA that keeps the opacity apart.
        full = image.convert("RGBA")
        opacity = full.getchannel("A")
        if opacity_separates(full):
            return Picture(_reduced(opacity, factor), True, factor)
        image = over_page(full)
    if image.mode in _GREYS:
        return Picture(_reduced(image.convert("L"), factor), False, factor)
    coloured = image.convert("RGB")
    grey = _reduced(coloured.convert("L"), factor)
    red, green, blue = coloured.split()
    if ImageChops.difference(red, green).getbbox() is None and ImageChops.difference(red, blue).getbbox() is None:
        return Picture(grey, False, factor)
    return Picture(grey, False, factor, np.asarray(coloured.reduce(factor) if factor > 1 else coloured))


def _reduced(image: Image.Image, factor: int) -> FloatArray:
    return np.asarray(image.reduce(factor) if factor > 1 else image, dtype=np.float64)


def _block_mean(values: FloatArray, factor: int) -> FloatArray:
    rows, columns = -values.shape[0] % factor, -values.shape[1] % factor
    padded = np.pad(values, ((0, rows), (0, columns)), mode="edge")
    blocks = padded.reshape(padded.shape[0] // factor, factor, padded.shape[1] // factor, factor)
    return np.asarray(blocks.mean(axis=(1, 3)), dtype=np.float64)

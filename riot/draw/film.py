"""The motion as a film: GIF, and MP4 where imageio-ffmpeg is installed. Ours."""

from __future__ import annotations

import importlib
import io
import os
import uuid
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageColor

from riot.draw.files import PictureFormatError
from riot.draw.keyframes import eased, frame_count, keyframes, loop_seconds, motion_marks, swept_box
from riot.draw.palette import LIGHT
from riot.draw.panels import sketch
from riot.draw.piece_image import NO_IMAGES, PieceImages
from riot.draw.raster import pixels_of_png, png_of_svg
from riot.draw.scene import Scene
from riot.draw.svg import CLOSING, naming, opening, painted
from riot.draw.tuning import (
    FILM_WIDTH,
    GIF_COLOURS,
    MOTION_PENS,
    MP4_QUALITY,
    MP4_RATE,
    PALETTE_CELL,
    PALETTE_FRAMES,
    PAUSE_FRAMES,
    SWEPT_MARGIN,
    WAY_FRAMES,
)
from riot.errors import needs_extra
from riot.motion.planner import motion_of
from riot.transform.transform import Transform
from riot.types import FloatArray

MODULE = "imageio_ffmpeg"


def write_film(
    transform: Transform, path: str | os.PathLike[str], width: int = FILM_WIDTH, images: PieceImages = NO_IMAGES
) -> None:
    """Write the motion from P to Q and back, a loop with pauses; the suffix (gif, mp4) chooses the format.

    ``width`` is in pixels; with ``images`` the pieces show their front. Raises `riot.draw.files.PictureFormatError` (a
    ValueError) for another suffix, `riot.errors.MissingExtraError` if an MP4 cannot be written here, and OSError if
    the file cannot be written. Ours.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from riot.groundtruth.pairs import dudeney, exact_transform
    >>> with TemporaryDirectory() as folder:
    ...     write_film(exact_transform(dudeney()), Path(folder) / "dudeney.gif", width=64)
    ...     (Path(folder) / "dudeney.gif").read_bytes()[:6]
    b'GIF89a'
    """
    target = Path(path)
    kind = target.suffix.lower()
    if kind == ".gif":
        target.write_bytes(_gif(_Camera(transform, width, 1, images)))
    elif kind == ".mp4":
        _mp4(target, film_writer(), _Camera(transform, width - width % 2, 2, images))  # the codec wants even sides
    else:
        raise PictureFormatError(f"cannot film {target.name!r}: use a file name that ends in .gif or .mp4")


def film_writer() -> Any:
    """The module that writes MP4; raises `riot.errors.MissingExtraError` if it is not installed."""
    with needs_extra("film"):
        return importlib.import_module(MODULE)


def _gif(camera: _Camera) -> bytes:
    frames = frame_count(camera.motion)
    there = [Image.fromarray(pixels_of_png(camera.picture(float(t)))) for t in eased(frames)]
    palette = _common_palette(there)
    there = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in there]
    step = 10 * round(50.0 * loop_seconds(frames) / (frames + PAUSE_FRAMES))  # milliseconds; a GIF counts hundredths
    film = [*there, *there[-2:0:-1]]
    durations = [step] * len(film)
    durations[0] += PAUSE_FRAMES * step
    durations[frames] += PAUSE_FRAMES * step
    stream = io.BytesIO()
    film[0].save(
        stream, "GIF", save_all=True, append_images=film[1:], duration=durations, loop=0, optimize=False, disposal=1
    )
    return stream.getvalue()


def _common_palette(frames: list[Image.Image]) -> Image.Image:
    """A picture with the colours that all frames share."""
    chosen = frames[:: max(1, len(frames) // PALETTE_FRAMES)]
    sheet = Image.new("RGB", (chosen[0].width, chosen[0].height * len(chosen)))
    for k, frame in enumerate(chosen):
        sheet.paste(frame, (0, k * frame.height))
    palette = sheet.quantize(GIF_COLOURS, dither=Image.Dither.NONE)
    # Paper is paper, which the mean of nearly white pixels is not; Pillow looks colours up in cells of eight.
    colours = np.array(palette.getpalette()).reshape(-1, 3)
    differences = np.abs(colours - ImageColor.getrgb(LIGHT["paper"])).max(axis=1)
    colours[differences < max(PALETTE_CELL, int(differences.min()) + 1)] = ImageColor.getrgb(LIGHT["paper"])
    palette.putpalette(colours.ravel().tolist())
    return palette


def _mp4(target: Path, writer: Any, camera: _Camera) -> None:
    frames = frame_count(camera.motion)
    half = round(0.5 * loop_seconds(frames) * MP4_RATE)
    rest = round(half * PAUSE_FRAMES / (frames + PAUSE_FRAMES))
    times = eased(half - rest)
    temporary = target.with_name(f".{target.stem}.{uuid.uuid4().hex}.mp4")
    # Without the encoder's name, one thread: the same film gives the same bytes.
    plain = ["-fflags", "+bitexact", "-flags:v", "+bitexact", "-map_metadata", "-1", "-threads", "1"]
    try:
        output = writer.write_frames(
            str(temporary), camera.size, fps=MP4_RATE, macro_block_size=2, quality=MP4_QUALITY, output_params=plain
        )
        output.send(None)
        for picture, count in _loop(camera, times, rest):
            for _ in range(count):
                output.send(picture)
        output.close()
        temporary.replace(target)
    finally:
        temporary.unlink(missing_ok=True)


def _loop(camera: _Camera, times: FloatArray, rest: int) -> Iterator[tuple[npt.NDArray[np.uint8], int]]:
    """Pictures of one loop, and how often each is shown."""
    there = [camera.picture(float(t)) for t in times]
    for k, picture in enumerate([*there, *there[-2:0:-1]]):
        yield pixels_of_png(picture), 1 + (rest if k in (0, len(there) - 1) else 0)


class _Camera:
    """Takes pictures of the motion, all in one frame whose height in pixels is a multiple of ``multiple``."""

    def __init__(self, transform: Transform, width: int, multiple: int, images: PieceImages) -> None:
        drawn, self.motion = sketch(transform), motion_of(transform)
        x0, y0, x1, y1 = swept_box(drawn, keyframes(self.motion, eased(WAY_FRAMES)), margin=SWEPT_MARGIN)
        pixel = (x1 - x0) / width
        height = multiple * round((y1 - y0) / pixel / multiple)
        box = (x0, y1 - height * pixel, x1, y1)
        self.size = width, height
        self._drawn, self._prefix = drawn, naming(drawn.pieces, images)
        self._scene = Scene("", box, (x1 - x0) / MOTION_PENS, drawn.pieces, (), images)
        self._opening = opening(self._scene, self._prefix, width, codec="PNG")

    def picture(self, t: float) -> bytes:
        """The PNG file of time t: all pixels of an MP4 would be too many to keep."""
        scene = replace(self._scene, marks=tuple(motion_marks(self._drawn, self.motion, t)))
        return png_of_svg(f"{self._opening}{painted(scene, self._prefix)}{CLOSING}", self.size[0])

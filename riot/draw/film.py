"""The motion as a film: GIF, and MP4 where imageio-ffmpeg is installed. Ours."""

from __future__ import annotations

import importlib
import io
import os
import uuid
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageDraw

from riot.draw.course import FRAMES, REST, calm, course, eased, loop_seconds, motion_marks, swept_box
from riot.draw.figure import PictureFormatError
from riot.draw.palette import LIGHT, PENS, colour, hue
from riot.draw.panels import sketch
from riot.draw.scene import Box, Dot, Part, Scene, placed
from riot.draw.skin import PLAIN, Skin, Skins
from riot.errors import RiotError
from riot.motion.planner import motion_of
from riot.transform.pose import rotate
from riot.transform.transform import Transform
from riot.types import FloatArray

WIDTH = 640
"""Pixels across."""

SMOOTH = 3
"""Every pixel is the mean of so many squared: edges without stairs."""

MP4_RATE = 30
"""Frames a second of an MP4; a GIF has as many as the animated SVG has key frames."""

COLOURS = 128
"""Of a GIF, the same in all its frames."""

MODULE = "imageio_ffmpeg"

_PENS_ACROSS = 520.0


class FilmError(RiotError, ModuleNotFoundError):
    """An MP4 was asked for where imageio-ffmpeg is not installed."""


def write_film(transform: Transform, path: str | os.PathLike[str], width: int = WIDTH, skins: Skins = PLAIN) -> None:
    """Write the motion from P to Q and back, a loop with pauses; the suffix (gif, mp4) chooses the format.

    ``width`` is in pixels; with ``skins`` the pieces show their front. Raises `riot.draw.figure.PictureFormatError` (a
    ValueError) for another suffix, `FilmError` if an MP4 cannot be written here, and OSError if the file cannot be
    written.
    """
    target = Path(path)
    kind = target.suffix.lower()
    if kind == ".gif":
        target.write_bytes(_gif(_Camera(transform, width, 1, skins)))
    elif kind == ".mp4":
        _mp4(transform, target, width, skins)
    else:
        raise PictureFormatError(f"cannot film {target.name!r}: use a file name that ends in .gif or .mp4")


def film_writer() -> Any:
    """The module that writes MP4; raises `FilmError` if it is not installed."""
    try:
        return importlib.import_module(MODULE)
    except ModuleNotFoundError:
        raise FilmError(
            "an MP4 needs the package imageio-ffmpeg, which is not installed: "
            "install it with pip install 'riot-shapes[film]', or ask for a GIF"
        ) from None


def _gif(camera: _Camera) -> bytes:
    frames = calm(camera.motion)
    there = [Image.fromarray(camera.picture(float(t))) for t in eased(frames)]
    palette = _common_palette(there)
    there = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in there]
    step = 10 * round(50.0 * loop_seconds(frames) / (frames + REST))  # milliseconds; a GIF counts hundredths
    film = [*there, *there[-2:0:-1]]
    durations = [step] * len(film)
    durations[0] += REST * step
    durations[frames] += REST * step
    stream = io.BytesIO()
    film[0].save(
        stream, "GIF", save_all=True, append_images=film[1:], duration=durations, loop=0, optimize=False, disposal=1
    )
    return stream.getvalue()


def _common_palette(frames: list[Image.Image]) -> Image.Image:
    """A picture with the colours that all frames share."""
    chosen = frames[:: max(1, len(frames) // 6)]
    sheet = Image.new("RGB", (chosen[0].width, chosen[0].height * len(chosen)))
    for k, frame in enumerate(chosen):
        sheet.paste(frame, (0, k * frame.height))
    return sheet.quantize(COLOURS, dither=Image.Dither.NONE)


def _mp4(transform: Transform, target: Path, width: int, skins: Skins) -> None:
    writer = film_writer()
    camera = _Camera(transform, width, 2, skins)  # the codec wants even sides
    frames = calm(motion_of(transform))
    half = round(0.5 * loop_seconds(frames) * MP4_RATE)
    rest = round(half * REST / (frames + REST))
    times = eased(half - rest)
    temporary = target.with_name(f".{target.stem}.{uuid.uuid4().hex}.mp4")
    # Without the encoder's name, one thread: the same film gives the same bytes.
    plain = ["-fflags", "+bitexact", "-flags:v", "+bitexact", "-map_metadata", "-1", "-threads", "1"]
    try:
        output = writer.write_frames(
            str(temporary), camera.size, fps=MP4_RATE, macro_block_size=2, quality=7, output_params=plain
        )
        output.send(None)
        for picture, count in _loop(camera, times, rest):
            for _ in range(count):
                output.send(picture)
        output.close()
        temporary.replace(target)
    finally:
        temporary.unlink(missing_ok=True)


def _loop(camera: _Camera, times: FloatArray, rest: int) -> Iterator[tuple[Any, int]]:
    """Pictures of one loop, and how often each is shown."""
    there = [float(t) for t in times]
    for k, t in enumerate([*there, *there[-2:0:-1]]):
        yield camera.picture(t), 1 + (rest if k in (0, len(there) - 1) else 0)


class _Camera:
    """Paints poses as pixels, all in one frame."""

    def __init__(self, transform: Transform, width: int, even: int, skins: Skins) -> None:
        self._drawn, self.motion, self._skins = sketch(transform), motion_of(transform), skins
        self._box: Box = swept_box(self._drawn, course(self.motion, eased(FRAMES)), margin=0.05)
        x0, y0, x1, y1 = self._box
        self._scale = SMOOTH * width / (x1 - x0)
        high = round(width * (y1 - y0) / (x1 - x0))
        self.size = width - width % even, high + high % even

    def picture(self, t: float) -> Any:
        """(height, width, 3) uint8 at time t."""
        marks = tuple(motion_marks(self._drawn, self.motion, t))
        scene = Scene("", self._box, 0.0, self._drawn.pieces, marks, self._skins)
        image = Image.new("RGB", (self.size[0] * SMOOTH, self.size[1] * SMOOTH), LIGHT["paper"])
        painter = ImageDraw.Draw(image)
        pen = self.size[0] * SMOOTH / _PENS_ACROSS
        for mark in scene.marks:
            if isinstance(mark, Part):
                look, skin = f"piece{hue(mark.piece, len(scene.pieces))}", scene.skin(mark)
                outline = self._pixels(placed(mark, scene.pieces[mark.piece].polygon))
                if skin is None:
                    painter.polygon(outline, fill=colour(look, LIGHT))
                else:
                    self._paste(image, mark, skin, outline)
                rim = PENS["cut" if skin else look]
                width = max(1, round(rim.width * pen))
                painter.line([*outline, outline[0]], fill=colour(rim.stroke or "paper", LIGHT), width=width)
            elif isinstance(mark, Dot):
                ((x, y),) = self._pixels(np.array([[mark.x, mark.y]]))
                radius, look_of = mark.radius * pen, PENS[mark.pen]
                painter.ellipse(
                    (x - radius, y - radius, x + radius, y + radius),
                    fill=colour(look_of.fill or "paper", LIGHT),
                    outline=colour(look_of.stroke or "ink", LIGHT),
                    width=max(1, round(look_of.width * pen)),
                )
        return np.asarray(image.reduce(SMOOTH))

    def _paste(self, image: Image.Image, part: Part, skin: Skin, outline: list[tuple[float, float]]) -> None:
        """Paint a piece's skin into its outline, in pixels of the image."""
        low = np.floor(np.min(outline, axis=0)).astype(int)
        size = tuple((np.ceil(np.max(outline, axis=0)).astype(int) - low + 1).tolist())
        # Where the image's corner and the ends of its first pixels lie in the skin, which is all of an affine map.
        x0, _, _, y1 = self._box
        corners = (low + np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])) / self._scale * [1.0, -1.0] + [x0, y1]
        own = rotate(corners - [part.x, part.y], -part.heading) / part.scale
        left, bottom, right, top = skin.box
        rows, columns = skin.pixels.shape[:2]
        at = (own - [left, top]) * [columns / (right - left), -rows / (top - bottom)]
        across, along = at[1] - at[0], at[2] - at[0]
        numbers = (across[0], along[0], at[0, 0], across[1], along[1], at[0, 1])
        seen = Image.fromarray(skin.pixels).transform(size, Image.Transform.AFFINE, numbers, Image.Resampling.BILINEAR)
        mask = Image.new("L", size)
        ImageDraw.Draw(mask).polygon([(x - low[0], y - low[1]) for x, y in outline], fill=255)
        image.paste(seen, tuple(low.tolist()), mask)

    def _pixels(self, points: FloatArray) -> list[tuple[float, float]]:
        x0, _, _, y1 = self._box
        return [((x - x0) * self._scale, (y1 - y) * self._scale) for x, y in points.tolist()]

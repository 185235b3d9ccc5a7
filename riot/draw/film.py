"""The motion as a film: GIF, and MP4 where there is ffmpeg. Ours."""

from __future__ import annotations

import io
import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from PIL import Image, ImageColor

from riot.draw.ffmpeg import write_mp4
from riot.draw.files import PictureFormatError
from riot.draw.film_camera import Camera
from riot.draw.keyframes import eased, frame_count, loop_seconds
from riot.draw.palette import LIGHT
from riot.draw.piece_image import NO_IMAGES, PieceImages
from riot.draw.tuning import (
    FILM_WIDTH,
    GIF_COLOURS,
    MP4_RATE,
    PALETTE_CELL,
    PALETTE_FRAMES,
    PAUSE_FRAMES,
    TURN_FRAMES,
)
from riot.transform.transform import Transform


def write_film(
    transform: Transform, path: str | os.PathLike[str], width: int = FILM_WIDTH, images: PieceImages = NO_IMAGES
) -> None:
    """Write the motion from P to Q and back, a loop with pauses; the suffix (gif, mp4) chooses the format.

    ``width`` is in pixels; with ``images`` the pieces show their front. If the hand sees Q on the back, the puzzle is
    turned over at the end (`riot.draw.panels.shown_from_back`). Raises `riot.draw.files.PictureFormatError` (a
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
        target.write_bytes(_gif(Camera(transform, width, 1, images)))
    elif kind == ".mp4":
        camera = Camera(transform, width - width % 2, 2, images)  # the codec wants even sides
        write_mp4(target, camera.size, _loop(camera))
    else:
        raise PictureFormatError(f"cannot film {target.name!r}: use a file name that ends in .gif or .mp4")


def _gif(camera: Camera) -> bytes:
    frames = frame_count(camera.motion)
    there = [camera.picture(float(t)) for t in eased(frames)]
    turned = [camera.turning(float(share)) for share in eased(TURN_FRAMES)[1:]] if camera.turns else []
    there += turned
    palette = _common_palette(there)
    there = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in there]
    step = 10 * round(50.0 * loop_seconds(frames) / (frames + PAUSE_FRAMES))  # milliseconds; a GIF counts hundredths
    film = [*there, *there[-2:0:-1]]
    durations = [step] * len(film)
    durations[0] += PAUSE_FRAMES * step
    durations[len(there) - 1] += PAUSE_FRAMES * step
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


def _loop(camera: Camera) -> Iterator[Image.Image]:
    """The frames of one loop of an MP4."""
    frames = frame_count(camera.motion)
    half = round(0.5 * loop_seconds(frames) * MP4_RATE)
    rest = round(half * PAUSE_FRAMES / (frames + PAUSE_FRAMES))
    there = [camera.picture(float(t)) for t in eased(half - rest)]
    if camera.turns:
        turn = round((half - rest) * TURN_FRAMES / frames)
        there += [camera.turning(float(share)) for share in eased(turn)[1:]]
    for k, picture in enumerate([*there, *there[-2:0:-1]]):
        for _ in range(1 + (rest if k in (0, len(there) - 1) else 0)):
            yield picture

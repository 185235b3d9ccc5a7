"""MP4 files by ffmpeg: the system's where there is one, else the one that comes with imageio-ffmpeg. Ours."""

from __future__ import annotations

import importlib
import shutil
import subprocess
import uuid
from collections.abc import Iterable
from pathlib import Path

from PIL import Image

from riot.draw.tuning import MP4_PRESET, MP4_QUALITY, MP4_RATE
from riot.errors import RiotError, needs_extra

PROGRAM, MODULE = "ffmpeg", "imageio_ffmpeg"


class FilmError(RiotError, RuntimeError):
    """What ffmpeg said when it could not write a film."""


def film_writer() -> str:
    """Path of ffmpeg; raises `riot.errors.MissingExtraError` if there is none."""
    program = shutil.which(PROGRAM)
    if program is None:
        with needs_extra("film"):
            program = importlib.import_module(MODULE).get_ffmpeg_exe()
    return str(program)


def write_mp4(target: Path, size: tuple[int, int], frames: Iterable[Image.Image]) -> None:
    """Write frames of ``size`` (even sides), `MP4_RATE` a second; the same frames give the same bytes by one ffmpeg.

    Raises as `film_writer`, `FilmError` if ffmpeg fails, OSError if the file cannot be written.
    """
    temporary = target.with_name(f".{target.stem}.{uuid.uuid4().hex}.mp4")
    command = [film_writer(), "-y", "-loglevel", "error", "-nostdin"]
    command += [
        "-f",
        "rawvideo",
        "-pix_fmt",
        "rgb24",
        "-s",
        f"{size[0]}x{size[1]}",
        "-r",
        str(MP4_RATE),
        "-i",
        "pipe:0",
    ]
    command += ["-c:v", "libx264", "-preset", MP4_PRESET, "-crf", str(MP4_QUALITY), "-pix_fmt", "yuv420p"]
    # Without the encoder's name, one thread: the same film gives the same bytes.
    command += ["-fflags", "+bitexact", "-flags:v", "+bitexact", "-map_metadata", "-1", "-threads", "1"]
    command += ["-movflags", "+faststart", str(temporary)]
    try:
        with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE) as process:
            assert process.stdin is not None and process.stderr is not None
            try:
                for frame in frames:
                    process.stdin.write(frame.tobytes())
                process.stdin.close()
            except BrokenPipeError:  # it has ended, and says why
                pass
            except BaseException:
                process.kill()
                raise
            message = process.stderr.read().decode(errors="replace").strip()
        if process.returncode:
            raise FilmError(f"ffmpeg could not write {target.name}: {message or process.returncode}")
        temporary.replace(target)
    finally:
        temporary.unlink(missing_ok=True)

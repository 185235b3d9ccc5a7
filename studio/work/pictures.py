"""Pictures, films and archives of a transform, as bytes to be downloaded."""

from __future__ import annotations

import io
import tempfile
import zipfile
from collections.abc import Mapping
from pathlib import Path

from riot.draw.animate import animate_svg
from riot.draw.figure import draw_transform
from riot.draw.film import write_film
from studio.work.material import Files, transform

MEDIA: Mapping[str, str] = {
    "riot": "application/json",
    "svg": "image/svg+xml",
    "png": "image/png",
    "pdf": "application/pdf",
    "gif": "image/gif",
    "mp4": "video/mp4",
    "swing.svg": "image/svg+xml",
    "stl": "application/zip",
    "3mf": "application/zip",
    "dxf": "application/zip",
    "laser.svg": "application/zip",
    "paper.pdf": "application/zip",
    "zip": "application/zip",
}
"""What can be downloaded, by kind."""

PUZZLE_FILES: Mapping[str, str] = {
    "stl": "*.stl",
    "3mf": "*.3mf",
    "dxf": "*.dxf",
    "laser.svg": "*.svg",
    "paper.pdf": "*.pdf",
}
"""Files of a puzzle by kind; several come as an archive."""

PICTURES = ("svg", "png", "pdf", "gif", "mp4", "swing.svg")
ZIPPED = ("svg", "png", "pdf", "gif", "swing.svg")
"""Pictures that the archive of everything holds."""

_EPOCH = (1980, 1, 1, 0, 0, 0)


def picture(files: Files, digest: str, kind: str) -> bytes:
    """A picture or film of a transform; raises `riot.errors.MissingExtraError` where MP4 cannot be written."""
    shown = transform(files, digest)
    if kind == "swing.svg":
        return animate_svg(shown).encode("utf-8")
    with tempfile.TemporaryDirectory(prefix="riot-studio-") as folder:
        path = Path(folder) / f"transform.{kind}"
        (write_film if kind in ("gif", "mp4") else draw_transform)(shown, path)
        return path.read_bytes()


def puzzle_archive(folder: Path, kind: str) -> bytes:
    """The files of a puzzle of one kind; KeyError if there are none."""
    paths = sorted(path for path in folder.rglob(PUZZLE_FILES[kind]) if path.is_file())
    if not paths:
        raise KeyError(kind)
    return archive({str(path.relative_to(folder)): path.read_bytes() for path in paths})


def everything(files: Files, digest: str, name: str, folder: Path | None) -> bytes:
    """The transform, its pictures, and all files of its puzzle if there is one, in an archive."""
    contents = {f"{name}.riot": files[digest]}
    contents |= {f"{name}.{kind}": picture(files, digest, kind) for kind in ZIPPED}
    if folder is not None:
        paths = sorted(path for path in folder.rglob("*") if path.is_file())
        contents |= {f"puzzle/{path.relative_to(folder)}": path.read_bytes() for path in paths}
    return archive(contents)


def archive(contents: Mapping[str, bytes]) -> bytes:
    """A zip file of these files; the same bytes every time.

    >>> archive({"a.txt": b"a"}) == archive({"a.txt": b"a"})
    True
    """
    held = io.BytesIO()
    with zipfile.ZipFile(held, "w", zipfile.ZIP_DEFLATED) as zipped:
        for name, data in contents.items():
            entry = zipfile.ZipInfo(name, _EPOCH)
            entry.create_system, entry.external_attr = 3, 0o644 << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            zipped.writestr(entry, data)
    return held.getvalue()

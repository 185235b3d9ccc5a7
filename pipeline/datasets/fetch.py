"""Fetch public data sets, as `riot fetch mpeg7` does. The decoded pixels are checked, not the archive.

The archive's packing may change and its pictures may be saved anew in another format: what counts is that every
picture shows the pixels that the manifest kept with the project lists.
"""

from __future__ import annotations

import contextlib
import csv
import hashlib
import lzma
import shutil
import tempfile
import zipfile
import zlib
from collections.abc import Iterable, Sequence
from dataclasses import astuple, dataclass
from pathlib import Path, PurePosixPath
from typing import BinaryIO

import numpy as np
from PIL import Image

from pipeline.datasets.collection import DatasetError
from pipeline.store.storage_errors import UNWRITABLE
from riot.errors import needs_extra
from riot.geometry.picture import PICTURE_FORMATS, PICTURE_SUFFIXES

with needs_extra("mine"):
    import pooch

MPEG7_URLS = ("http://www.dabi.temple.edu/~shape/MPEG7/MPEG7dataset.zip",)
"""Tried in order. The first is the authors' own (Latecki, Lakämper, Eckhardt, CVPR 2000)."""

MPEG7_MANIFEST = Path(__file__).parent / "manifests" / "mpeg7.csv"

MOST_PIXELS = 10_000_000
"""Pixels that a picture may have before it is decoded; those of MPEG-7 have at most a tenth (ours)."""

_NO_ARCHIVE = (zipfile.BadZipFile, NotImplementedError, RuntimeError, EOFError, zlib.error, lzma.LZMAError, ValueError)
"""Errors of `zipfile` for an archive that is damaged, encrypted, or packed by an unknown method."""

TIMEOUT = 60.0
"""Seconds without an answer after which an address is given up (ours)."""


@dataclass(frozen=True)
class DownloadLimits:
    """Bytes that the archive and its unpacked pictures may have at most: a larger archive is not this data set.

    The pictures of MPEG-7, unpacked, have a tenth of ``download``.
    """

    download: int = 50_000_000
    unpacked: int = 500_000_000


DOWNLOAD_LIMITS = DownloadLimits()


@dataclass(frozen=True)
class ManifestEntry:
    """One picture of a manifest: its file name without suffix, size, and SHA-256 of its binary pixels."""

    name: str
    width: int
    height: int
    sha256: str


def fetch(
    target: Path,
    urls: Sequence[str] = MPEG7_URLS,
    manifest: Path = MPEG7_MANIFEST,
    *,
    timeout: float = TIMEOUT,
    limits: DownloadLimits = DOWNLOAD_LIMITS,
) -> bool:
    """Put a data set into the folder ``target``, complete and checked, or leave nothing; False if it is already there.

    Raises `DatasetError` if no address answers, the archive is damaged, pictures are missing or altered, or the folder
    has other content or cannot be written.
    """
    entries = read_manifest(manifest)
    if target.exists() and not target.is_dir():
        raise DatasetError(f"{target}: exists, and is not a folder; give another folder")
    if target.exists() and any(target.iterdir()):
        faults = check(target, entries)
        if not faults:
            return False
        raise DatasetError(f"{target}: exists, and is not the data set ({_summary(faults)}); remove or rename it")
    new_parent = not target.parent.exists()
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=f".{target.name}-", dir=target.parent) as temporary:
            archive = _download(urls, Path(temporary), timeout, limits.download)
            pictures = Path(temporary) / "pictures"
            pictures.mkdir()
            _unpack(archive, pictures, entries, limits.unpacked)
            faults = check(pictures, entries)
            if faults:
                raise DatasetError(
                    f"the archive from {archive.name}: {_summary(faults)}; nothing was kept. Get the data set "
                    "elsewhere and give dataset.root=DIR"
                )
            if target.exists():
                target.rmdir()
            pictures.replace(target)
    except OSError as error:
        if isinstance(error, DatasetError):
            raise
        raise DatasetError(f"{target}: cannot be written ({error.strerror or error}); give another folder") from error
    finally:
        if new_parent:
            with contextlib.suppress(OSError):  # not empty once the data set is in it
                target.parent.rmdir()
    return True


def check(folder: Path, entries: Iterable[ManifestEntry]) -> list[str]:
    """List the pictures of ``entries`` that are missing, unreadable or altered in a folder, a line for each."""
    files = {path.stem.casefold(): path for path in sorted(folder.iterdir()) if path.suffix.lower() in PICTURE_SUFFIXES}
    faults: list[str] = []
    for entry in entries:
        path = files.get(entry.name.casefold())
        if path is None:
            faults.append(f"{entry.name} is missing")
        elif (actual := _entry_or_none(path, entry.name)) is None:
            faults.append(f"{entry.name} is no picture")
        elif actual != entry:
            faults.append(f"{entry.name} is altered")
    return faults


def entry_of(path: Path, name: str) -> ManifestEntry:
    """The manifest entry of a picture file: each pixel is object if any of red, green, blue is not zero."""
    with Image.open(path, formats=PICTURE_FORMATS) as image:
        if image.width * image.height > MOST_PIXELS:
            raise ValueError(f"{path}: too large")
        pixels = np.asarray(image.convert("RGB")).any(axis=2)
    return ManifestEntry(
        name, pixels.shape[1], pixels.shape[0], hashlib.sha256(np.packbits(pixels).tobytes()).hexdigest()
    )


def read_manifest(path: Path) -> list[ManifestEntry]:
    """Entries of a manifest file; raises `DatasetError` if it is missing or damaged."""
    try:
        with path.open(newline="", encoding="utf-8") as file:
            return [
                ManifestEntry(row["name"], int(row["width"]), int(row["height"]), row["sha256"])
                for row in csv.DictReader(file)
            ]
    except (OSError, KeyError, ValueError) as error:
        raise DatasetError(f"{path}: no manifest of pictures ({error}); install the project again") from error


def write_manifest(folder: Path, path: Path) -> int:
    """List the pictures of a folder into a manifest file, sorted by name; returns their number.

    Raises `DatasetError` for a folder without pictures, OSError or ValueError for a damaged one; then nothing is
    written.
    """
    files = sorted(file for file in folder.iterdir() if file.suffix.lower() in PICTURE_SUFFIXES)
    if not files:
        raise DatasetError(f"{folder}: no pictures here ({', '.join(PICTURE_SUFFIXES)})")
    entries = [entry_of(picture, picture.stem) for picture in files]
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["name", "width", "height", "sha256"])
        writer.writerows(astuple(entry) for entry in entries)
    return len(entries)


def _entry_or_none(path: Path, name: str) -> ManifestEntry | None:
    try:
        return entry_of(path, name)
    except Exception:  # decoders raise nearly anything on damaged files; the caller reports which it was
        return None


class _TooLong(ValueError):
    """A download is longer than any archive of the data set."""


class _Limited:
    """A file that accepts a limited number of bytes: a server may send more than it announces."""

    def __init__(self, file: BinaryIO, most: int) -> None:
        self._file, self._most, self._left = file, most, most

    def write(self, data: bytes) -> int:
        """Write, or raise `_TooLong`."""
        self._left -= len(data)
        if self._left < 0:
            raise _TooLong(f"more than {self._most} bytes; this is another file")
        return self._file.write(data)

    def flush(self) -> None:
        """See `io.IOBase.flush`."""
        self._file.flush()


def _download(urls: Sequence[str], folder: Path, timeout: float, most: int) -> Path:
    pooch.get_logger().setLevel("WARNING")
    downloader = pooch.HTTPDownloader(timeout=timeout)

    def download(url: str, file: str, pup: pooch.Pooch | None) -> None:
        with Path(file).open("wb") as whole:
            downloader(url, _Limited(whole, most), pup)

    failures: list[str] = []
    for url in urls:
        name = PurePosixPath(url).name or "archive.zip"
        try:
            return Path(
                pooch.retrieve(
                    url,
                    known_hash=None,  # none is published; the pictures are checked instead
                    fname=name,
                    path=folder,
                    downloader=download,
                )
            )
        except _TooLong as error:
            failures.append(f"{url} ({error})")
        except Exception as error:  # whatever this address raises, the next may answer
            if isinstance(error, OSError) and error.errno in UNWRITABLE:
                raise  # no address helps against a full disk
            failures.append(f"{url} ({type(error).__name__}: {str(error)[:200]})")
    raise DatasetError(
        "no address gives the data set; check the network, or get it elsewhere and give dataset.root=DIR. Tried: "
        + "; ".join(failures)
    )


def _unpack(archive: Path, folder: Path, entries: Iterable[ManifestEntry], most: int) -> None:
    """Unpack the pictures that the manifest lists, under the manifest's names; paths in the archive are not used."""
    wanted = {entry.name.casefold(): entry.name for entry in entries}
    try:
        with zipfile.ZipFile(archive) as packed:
            members = [info for info in packed.infolist() if not info.is_dir()]
            if sum(info.file_size for info in members) > most:
                raise DatasetError(f"{archive.name}: unpacks to more than {most} bytes; this is another archive")
            for info in members:
                inner = PurePosixPath(info.filename)
                name = wanted.get(inner.stem.casefold())
                if name is None or inner.suffix.lower() not in PICTURE_SUFFIXES or inner.name.startswith("."):
                    continue
                path = folder / (name + inner.suffix.lower())
                with packed.open(info) as source, path.open("wb") as sink:
                    shutil.copyfileobj(source, sink)
    except _NO_ARCHIVE as error:
        raise DatasetError(f"{archive.name}: no archive that can be unpacked ({error}); try again later") from error


def _summary(faults: list[str], shown: int = 5) -> str:
    more = f" and {len(faults) - shown} more" if len(faults) > shown else ""
    return ", ".join(faults[:shown]) + more

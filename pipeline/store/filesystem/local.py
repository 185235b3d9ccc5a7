"""Files in a folder of this machine, or one that it mounts.

A file is written under a unique name in its folder, synced and renamed. Its writer has it locked until then: a
temporary file that can be locked belongs to nobody, whatever the clock says, and no lock outlives its process.
"""

from __future__ import annotations

import contextlib
import fcntl
import mmap
import os
import shutil
import stat
import uuid
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from pipeline.store.filesystem.base import Data

TEMPORARY = ".tmp-"

PROBE_SIZE = 2**16
"""Bytes that `LocalFiles.probe` writes: an empty file can be made on a full disk, too."""

MAPPED_SIZE = 2**18
"""Files of this many bytes or more are mapped into memory; smaller ones, such as blocks of scores, are read faster."""


@dataclass(frozen=True)
class LocalFiles:
    """See `pipeline.store.filesystem.base.Files`."""

    location: Path
    threads = 4

    def exists(self) -> bool:
        """See `Files.exists`."""
        return self.location.is_dir()

    def probe(self) -> None:
        """See `Files.probe`."""
        probe = self.location / f"{TEMPORARY}{uuid.uuid4().hex}"
        self.location.mkdir(parents=True, exist_ok=True)
        write_atomically(probe, bytes(PROBE_SIZE))
        probe.unlink()

    def read(self, name: str) -> memoryview:
        """See `Files.read`; large files are mapped."""
        try:
            with (self.location / name).open("rb") as stream:
                if os.fstat(stream.fileno()).st_size < MAPPED_SIZE:
                    return memoryview(stream.read())
                return memoryview(mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ))
        except NotADirectoryError as error:
            raise FileNotFoundError(*error.args) from error

    def write(self, folder: str, files: Mapping[str, Data]) -> None:
        """See `Files.write`."""
        path = self.location / folder
        path.mkdir(parents=True, exist_ok=True)
        for name, data in files.items():
            _replace(path / name, data)
        # One sync for all names: a crash that kept only a later one leaves a miss, as any other torn artifact.
        sync_folder(path)

    def names(self, folder: str) -> Iterator[str]:
        """See `Files.names`."""
        with contextlib.suppress(FileNotFoundError, NotADirectoryError):
            yield from sorted(path.name for path in (self.location / folder).iterdir())

    def sizes(self, folder: str) -> dict[str, int]:
        """See `Files.sizes`."""
        return {name: size for name, (size, _) in self.stamps(folder).items()}

    def stamps(self, folder: str) -> dict[str, tuple[int, float]]:
        """See `Files.stamps`."""
        stamps = {}
        for name in self.names(folder):
            with contextlib.suppress(FileNotFoundError):  # another process has removed it
                status = (self.location / folder / name).stat()
                if stat.S_ISREG(status.st_mode):
                    stamps[name] = (status.st_size, status.st_mtime_ns / 1e9)
        return stamps

    def remove(self, name: str) -> None:
        """See `Files.remove`."""
        path = self.location / name
        with contextlib.suppress(FileNotFoundError):
            if path.is_dir() and not path.is_symlink():
                shutil.rmtree(path)
            else:
                path.unlink()

    def abandoned(self, folder: str) -> list[str]:
        """See `Files.abandoned`; where files cannot be locked, none is."""
        path = self.location / folder
        return [name for name in self.names(folder) if name.startswith(TEMPORARY) and _is_free(path / name)]

    @contextlib.contextmanager
    def shared(self) -> Iterator[None]:
        """See `Files.shared`; the folder itself is locked, so that no lock file is left."""
        with _locked(self.location, fcntl.LOCK_SH):
            yield

    @contextlib.contextmanager
    def alone(self) -> Iterator[bool]:
        """See `Files.alone`."""
        with _locked(self.location, fcntl.LOCK_EX | fcntl.LOCK_NB) as held:
            yield held


def write_atomically(path: Path, data: bytes) -> None:
    """Write a file so that readers see the old one, the new one or none, and a crash leaves no torn one."""
    _replace(path, data)
    sync_folder(path.parent)


def sync_folder(folder: Path) -> None:
    """Make renames in a folder durable, where the file system can."""
    with contextlib.suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def _replace(path: Path, data: Data) -> None:
    temporary = path.with_name(f"{TEMPORARY}{uuid.uuid4().hex}")
    try:
        with temporary.open("wb") as stream:
            with contextlib.suppress(OSError):  # without locks here nobody takes it for abandoned either
                fcntl.flock(stream, fcntl.LOCK_EX)
            stream.writelines([data] if isinstance(data, bytes) else data)
            stream.flush()
            os.fsync(stream.fileno())
            temporary.replace(path)
    except BaseException:
        with contextlib.suppress(OSError):
            temporary.unlink()
        raise


def _is_free(file: Path) -> bool:
    with _locked(file, fcntl.LOCK_EX | fcntl.LOCK_NB) as held:
        return held


@contextlib.contextmanager
def _locked(path: Path, how: int) -> Iterator[bool]:
    """Lock a file or folder while entered; yields False when it is gone, is locked, or cannot be locked."""
    try:
        descriptor = os.open(path, os.O_RDONLY)
    except OSError:
        yield False
        return
    try:
        try:
            fcntl.flock(descriptor, how)
        except OSError:
            yield False
        else:
            yield True
    finally:
        os.close(descriptor)

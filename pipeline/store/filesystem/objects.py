"""Files on an object store, by way of fsspec: ``s3://bucket/prefix`` with the extra ``s3``.

An object is put whole or not at all, and two writers of one key put the same bytes, so that neither temporary names
nor conditions are needed. Credentials and endpoints are those of the protocol's own configuration.
"""

from __future__ import annotations

import contextlib
import importlib
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from pipeline.errors import StartError
from pipeline.store.filesystem.base import Data
from pipeline.store.location import Url
from riot.errors import MissingExtraError, needs_extra


@dataclass(frozen=True)
class ObjectFiles:
    """See `pipeline.store.filesystem.base.Files`; ``system`` is an fsspec file system that keeps no listings."""

    location: Url
    system: Any
    threads = 32

    def exists(self) -> bool:
        """See `Files.exists`."""
        with _failing(self.location):
            return bool(self.system.exists(self._path("")))

    def probe(self) -> None:
        """See `Files.probe`."""
        self.write("", {".probe": b"probe"})
        self.remove(".probe")

    def read(self, name: str) -> memoryview:
        """See `Files.read`."""
        with _failing(self.location):
            # In one request: several at once would be preceded by another, for the length.
            return memoryview(self.system.cat_file(self._path(name), max_concurrency=1))

    def write(self, folder: str, files: Mapping[str, Data]) -> None:
        """See `Files.write`: an object that was put is durable."""
        with _failing(self.location):
            for name, data in files.items():
                self.system.pipe_file(self._path(folder, name), data if isinstance(data, bytes) else b"".join(data))

    def names(self, folder: str) -> Iterator[str]:
        """See `Files.names`; fsspec asks for one page after another."""
        yield from sorted(self._listed(folder))

    def sizes(self, folder: str) -> dict[str, int]:
        """See `Files.sizes`."""
        return {name: size for name, (size, _) in self.stamps(folder).items()}

    def stamps(self, folder: str) -> dict[str, tuple[int, float]]:
        """See `Files.stamps`; S3 tells the time, in whole seconds, and other stores may not."""
        listed = self._listed(folder)
        return {
            name: (int(listed[name]["size"]), _seconds(listed[name].get("LastModified")))
            for name in sorted(listed)
            if listed[name]["type"] == "file"
        }

    def remove(self, name: str) -> None:
        """See `Files.remove`."""
        with _failing(self.location), contextlib.suppress(FileNotFoundError):
            self.system.rm(self._path(name), recursive=True)

    def abandoned(self, folder: str) -> list[str]:
        """See `Files.abandoned`: there are no temporary files here."""
        return []

    @contextlib.contextmanager
    def shared(self) -> Iterator[None]:
        """See `Files.shared`: an object store has no locks."""
        yield

    @contextlib.contextmanager
    def alone(self) -> Iterator[bool]:
        """See `Files.alone`: it cannot be known."""
        yield False

    def _path(self, *names: str) -> str:
        return "/".join([str(self.system._strip_protocol(self.location)), *filter(None, names)])

    def _listed(self, folder: str) -> dict[str, Any]:
        path = self._path(folder)
        with _failing(self.location), contextlib.suppress(FileNotFoundError, NotADirectoryError):
            entries = self.system.ls(path, detail=True)
            # Some stores have an empty object of the folder's own name.
            below = [entry for entry in entries if entry["name"].strip("/") != path.strip("/")]
            return {entry["name"].rstrip("/").rpartition("/")[2]: entry for entry in below}
        return {}


def _seconds(time: Any) -> float:
    return time.timestamp() if isinstance(time, datetime) else math.nan


def open_objects(location: Url) -> ObjectFiles:
    """The files below a URL; raises `StartError` when fsspec does not know the protocol or lacks its package."""
    try:
        with needs_extra("s3"):
            import fsspec  # type: ignore[import-untyped]

            if location.startswith("s3://"):
                importlib.import_module("s3fs")  # which fsspec would miss in words of its own
        system, _ = fsspec.url_to_fs(location, use_listings_cache=False)
    except MissingExtraError as error:
        raise StartError(f"{location}: {error}") from error
    except (ImportError, ValueError) as error:
        raise StartError(f"{location}: cannot be opened ({error}); give a folder, or s3://BUCKET/PREFIX") from error
    return ObjectFiles(location, system)


@contextlib.contextmanager
def _failing(location: Url) -> Iterator[None]:
    """Clients raise errors of their own for networks and services that fail; here all of them are OSError."""
    try:
        yield
    except OSError:
        raise
    except Exception as error:
        raise OSError(f"{location}: {type(error).__name__}: {error}") from error

"""The few things that a store asks of the place it is in, and how places are named."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Protocol


class Url(str):
    """A place on an object store that fsspec knows, such as ``s3://bucket/prefix``; one spelling for each place."""

    __slots__ = ()

    def __new__(cls, text: str) -> Url:
        """Raises ValueError for text that is no URL."""
        scheme, mark, rest = text.partition("://")
        if not (scheme.isalnum() and mark and rest.strip("/")):
            raise ValueError(f"{text!r} is no URL; give PROTOCOL://PLACE, such as s3://bucket/prefix")
        return super().__new__(cls, f"{scheme}://{rest.strip('/')}")

    def joinpath(self, *names: str) -> Url:
        """The place below this one."""
        return Url("/".join([self, *names]))


Place = Path | Url


def place_of(text: str | Path) -> Place:
    """A URL if the text is one, else a path."""
    return Url(text) if isinstance(text, str) and "://" in text else Path(text)


class Files(Protocol):
    """Files by name below one place; a name's parts are separated by ``/``.

    Every method may raise OSError, and nothing else, when the place fails. Any number of processes may use it at once.
    """

    @property
    def place(self) -> Place:
        """Where this is."""

    @property
    def threads(self) -> int:
        """How many reads are worth having under way at once."""

    def exists(self) -> bool:
        """Whether the place is there."""

    def probe(self) -> None:
        """Make the place if need be, write a file there and remove it; raises OSError when that cannot be done."""

    def read(self, name: str) -> memoryview:
        """All bytes of a file; raises FileNotFoundError when there is none."""

    def write(self, folder: str, files: Mapping[str, bytes]) -> None:
        """Write files of a folder, in order: a later one is there only when the earlier ones are, each old or new.

        Once this has returned they outlast a crash of the machine.
        """

    def names(self, folder: str) -> Iterator[str]:
        """Names of what is right in a folder, sorted; none when it is not there."""

    def sizes(self, folder: str) -> dict[str, int]:
        """Bytes of the files right in a folder, by name; empty when it is not there."""

    def remove(self, name: str) -> None:
        """Remove a file, or a folder with everything in it; whatever is gone already is no error."""

    def abandoned(self, folder: str) -> list[str]:
        """Names of the temporary files right in a folder that no living writer has."""

    def shared(self) -> AbstractContextManager[None]:
        """While entered, nobody gets `alone`; not held any more once the process is gone, however it went."""

    def alone(self) -> AbstractContextManager[bool]:
        """Entered with whether nobody else holds the place; False where that cannot be known."""

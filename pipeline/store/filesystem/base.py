"""What a store needs of a file system, as a protocol: a folder and an object store implement it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from typing import Protocol

from pipeline.store.location import Location

Data = bytes | Sequence[bytes | memoryview]
"""The bytes of a file, or pieces of them in order."""


class Files(Protocol):
    """Files by name below one location; a name's parts are separated by ``/``.

    Every method may raise OSError, and nothing else, when the file system fails. Any number of processes may use it at
    once.
    """

    @property
    def location(self) -> Location:
        """Where this is."""

    @property
    def threads(self) -> int:
        """How many reads are worth having under way at once."""

    def exists(self) -> bool:
        """Whether the location exists."""

    def probe(self) -> None:
        """Create the location if it is missing, write a file there and remove it; raises OSError when that fails."""

    def read(self, name: str) -> memoryview:
        """All bytes of a file; raises FileNotFoundError when there is none."""

    def write(self, folder: str, files: Mapping[str, Data]) -> None:
        """Write files of a folder, in order: a later one is there only when the earlier ones are, each old or new.

        Once this has returned they outlast a crash of the machine.
        """

    def names(self, folder: str) -> Iterator[str]:
        """Names of what is right in a folder, sorted; none when it is not there."""

    def sizes(self, folder: str) -> dict[str, int]:
        """Bytes of the files right in a folder, by name; empty when it is not there."""

    def stamps(self, folder: str) -> dict[str, tuple[int, float]]:
        """Bytes, and time of the last change in seconds, of the files right in a folder; nan for an unknown time."""

    def remove(self, name: str) -> None:
        """Remove a file, or a folder with everything in it; whatever is gone already is no error."""

    def abandoned(self, folder: str) -> list[str]:
        """Names of the temporary files right in a folder that no living writer has."""

    def shared(self) -> AbstractContextManager[None]:
        """While entered, nobody gets `alone`; not held any more once the process is gone, however it went."""

    def alone(self) -> AbstractContextManager[bool]:
        """Entered with whether no other process is inside `shared` or `alone`; False where that is unknown."""

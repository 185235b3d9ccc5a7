"""Folders that are written as a whole or not at all. Ours."""

from __future__ import annotations

import contextlib
import errno
import shutil
import tempfile
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path

from riot.errors import RiotError

PUZZLE_FILES = (
    "piece-*.stl",
    "chain*.stl",
    "tray-*.stl",
    "pin*.stl",
    "cap*.stl",
    "sleeve*.stl",
    "plate-*.3mf",
    "laser-*.*",
    "texture-*.pdf",
)
"""Files whose number or presence depends on the puzzle: those of an older one must not lie beside a new one's."""


class InUseError(RiotError, FileExistsError):
    """A folder or file that is there already, and that nobody asked to replace."""


def check_folder(folder: Path, *, replace_files: bool = False) -> None:
    """Raise OSError, which names ``folder``, unless it can be made, or is there and empty (or may be written over).

    Raises `InUseError` for a folder that holds something, unless ``replace_files``. Nothing is left behind.
    """
    if folder.exists() and not folder.is_dir():
        raise NotADirectoryError(errno.ENOTDIR, "a file, where results need a folder", str(folder))
    if folder.exists() and not replace_files and any(folder.iterdir()):
        raise InUseError(
            f"{folder} is there already, and is not empty: name another folder, or replace what is in it "
            "(replace_files)"
        )
    with _told_of(folder), _parents(folder) as parents:
        parents.keep = False
        Path(tempfile.mkdtemp(prefix=".riot-", dir=folder if folder.exists() else folder.parent)).rmdir()
        if not folder.exists():
            folder.mkdir()
            folder.rmdir()


def check_files(paths: Collection[Path], *, replace_files: bool = False) -> None:
    """Raise `InUseError` if one of the files is there already, unless ``replace_files``."""
    if not replace_files and (there := sorted(path for path in paths if path.exists())):
        more = f", as are {len(there) - 1} more" if len(there) > 1 else ""
        raise InUseError(f"{there[0]} is there already{more}: name another folder, or replace them (replace_files)")


@contextmanager
def new_folder(folder: Path, *, replace_files: bool = False, stale: Collection[str] = ()) -> Iterator[Path]:
    """A temporary folder beside ``folder`` that takes its name when all is done, or is deleted with what is in it.

    With ``replace_files`` a folder that is there stays, its files that match a pattern of ``stale`` go, and the new
    files come in, over those of the same names. Raises as `check_folder`.
    """
    check_folder(folder, replace_files=replace_files)
    with _told_of(folder), _parents(folder) as parents:
        temporary = Path(tempfile.mkdtemp(prefix=".riot-", dir=folder.parent))
        try:
            temporary.chmod(0o755)
            yield temporary
            if folder.exists() and any(folder.iterdir()):
                for path in [path for pattern in stale for path in folder.glob(pattern)]:
                    path.unlink()
                move_files(temporary, folder)
            else:
                with contextlib.suppress(FileNotFoundError):
                    folder.rmdir()
                temporary.rename(folder)
            parents.keep = True
        finally:
            shutil.rmtree(temporary, ignore_errors=True)


def move_files(source: Path, target: Path) -> list[Path]:
    """Move all files and folders of a folder into another, over those of the same names; returns where files are."""
    target.mkdir(parents=True, exist_ok=True)
    moved: list[Path] = []
    for path in sorted(source.iterdir()):
        if path.is_dir():
            moved += move_files(path, target / path.name)
        else:
            moved.append(path.replace(target / path.name))
    return moved


@contextmanager
def _told_of(folder: Path) -> Iterator[None]:
    """Errors of the operating system that name another path name the folder that the user does."""
    try:
        yield
    except OSError as error:
        if isinstance(error, RiotError) or error.errno is None:
            raise
        raise type(error)(error.errno, error.strerror, str(folder)) from error


class _Parents:
    """Whether the folders that were made for a folder stay."""

    keep = False


@contextmanager
def _parents(folder: Path) -> Iterator[_Parents]:
    """Make the folders above ``folder``; unless they are to stay, those that are new go again."""
    missing = []
    for parent in folder.parents:
        if parent.exists():
            if not parent.is_dir():
                raise NotADirectoryError(errno.ENOTDIR, f"{parent.name} is a file, not a folder", str(folder))
            break
        missing.append(parent)
    parents = _Parents()
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        yield parents
    finally:
        if not parents.keep:
            for parent in missing:
                with contextlib.suppress(OSError):
                    parent.rmdir()

"""Collections of silhouettes: which items there are, and in which classes."""

from __future__ import annotations

import hashlib
import os
import re
import unicodedata
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, NoReturn

from pipeline.datasets import sample
from pipeline.datasets.item import Item
from riot.errors import ParameterError, RiotError, needs_extra
from riot.geometry.picture import PICTURE_SUFFIXES
from riot.parameters.field import ParameterGroup, parameter

with needs_extra("mine"):
    from platformdirs import user_cache_path

PICTURES = frozenset({*PICTURE_SUFFIXES, ".svg", ".svgz"})
"""Files with these suffixes are items of a collection. Ingest finds out whether they can be read."""

DUPLICATE = "duplicate"
"""Reason of a file that is left out because another one has the same bytes."""

Kind = Literal["sample", "folder", "mpeg7", "animals", "paper"]

_FOLDERS: dict[Kind, tuple[str, ...]] = {
    "sample": (),
    "folder": ("root",),
    "mpeg7": ("root",),
    "animals": ("root",),
    "paper": ("root", "mpeg7", "animals"),
}
_OWN_PICTURES = "your own pictures are +dataset=folder dataset.root=DIR"


class DatasetError(RiotError, FileNotFoundError):
    """A data set that is missing, empty or unreadable as a whole; the message says how to get it."""


@dataclass(frozen=True)
class DatasetConfig(ParameterGroup):
    """Which collection a run mines."""

    name: str = parameter("sample", meaning="Names the folder of the outputs.")
    kind: Kind = parameter("sample", meaning="How the collection is laid out; dataset=KIND sets it.")
    root: str | None = parameter(
        None,
        meaning="Folder with the pictures; null = the data set's place in the user's cache folder. Of paper: a folder "
        "that holds mpeg7 and animals.",
    )
    mpeg7: str | None = parameter(None, meaning="Folder with MPEG-7, instead of the one in root (paper).")
    animals: str | None = parameter(None, meaning="Folder with the animals, instead of the one in root (paper).")
    limit: int | None = parameter(
        None, at_least=1, meaning="Take so many items only, spread evenly over the collection; null = all."
    )

    def check_together(self) -> None:
        """Refuse a name that is no folder's, and folders that this kind does not read; raises `ParameterError`."""
        if self.name in ("", ".", "..") or "/" in self.name or "\\" in self.name:
            raise ParameterError("name", f"{self.name!r} cannot name a folder of the outputs")
        for option in ("root", "mpeg7", "animals"):
            folder = getattr(self, option)
            if folder == "":
                raise ParameterError(option, "expected a folder, got nothing; the folder you are in is `.`")
            if folder is not None and option not in _FOLDERS[self.kind]:
                own = ", ".join(f"dataset.{name}" for name in ("name", *_FOLDERS[self.kind], "limit"))
                raise ParameterError(option, f"the data set {self.kind} has {own} only; {_OWN_PICTURES}")


@dataclass(frozen=True)
class Rejected:
    """A file that has the suffix of a picture and cannot be an item; ``reason`` is one word, ``message`` a sentence.

    ``stage`` is the stage that rejected it, ``type`` the type of the error, after ``attempts`` attempts.
    """

    name: str
    source: str
    reason: str
    message: str
    stage: str = "collect"
    type: str = "Rejected"
    attempts: int = 1


@dataclass(frozen=True)
class Collection:
    """Items, sorted by name, no two with the same bytes; ``ignored`` counts the files without a picture's suffix."""

    name: str
    items: tuple[Item, ...]
    rejected: tuple[Rejected, ...] = ()
    ignored: int = 0


def collect(config: DatasetConfig) -> Collection:
    """List and hash the items of a collection; raises `DatasetError` if there is none."""
    if config.kind == "sample":
        collection = Collection(config.name, tuple(Item(*definition) for definition in sample.definitions()))
    elif config.kind == "folder":
        if config.root is None:
            raise DatasetError("dataset.root: which folder? Give dataset.root=DIR")
        collection = _listed(
            config.name, Path(config.root).expanduser(), "give dataset.root=DIR, a folder with pictures"
        )
    elif config.kind == "mpeg7":
        collection = _mpeg7(config.name, _root(config.root, "mpeg7"))
    elif config.kind == "animals":
        collection = _animals(config.name, _root(config.root, "animals"))
    else:
        collection = _paper(config)
    return _limited(collection, config.limit)


def default_root(kind: str) -> Path:
    """The folder of a public data set if the user names none: it is in the user's cache folder."""
    return user_cache_path("riot") / kind


def class_of(name: str) -> str:
    """The class of an item: its sub-folder, else its file name before the last ``-`` or ``_`` and digits, else none.

    >>> class_of("fish/7"), class_of("fish-7"), class_of("fish"), class_of("obj10_1.pgm")
    ('fish', 'fish', '', 'obj10')
    """
    folder, _, stem = name.rpartition("/")
    return folder or _class_of_stem(stem)


def _class_of_stem(stem: str) -> str:
    # An inner suffix, as of obj10_1.pgm.png, is that of an earlier format.
    match = re.fullmatch(r"(.+?)[-_]+[0-9]+(?:\.[A-Za-z]{2,4})?", stem)
    return match[1] if match else ""


def _root(folder: str | None, kind: str) -> Path:
    return Path(folder).expanduser() if folder is not None else default_root(kind)


def _mpeg7(name: str, root: Path, option: str = "root") -> Collection:
    get = f"`python -m pipeline.fetch mpeg7` gets it, or give dataset.{option}=DIR"
    collection = _listed(name, root, get)
    # The archive keeps all pictures in one folder, whose name is no class.
    items = [replace(item, cls=_class_of_stem(item.name.rpartition("/")[2])) for item in collection.items]
    return replace(collection, items=tuple(items))


def _animals(name: str, root: Path, option: str = "root") -> Collection:
    return _listed(
        name,
        root,
        "this data set (Bai, Liu, Tu 2009: 2,000 pictures) has no public address; "
        f"give dataset.{option}=DIR, a folder with 20 sub-folders, one a class, of 100 pictures each",
    )


def _paper(config: DatasetConfig) -> Collection:
    """Join both data sets, with names below ``mpeg7/`` and ``animals/``; classes of the same name become one class.

    The paper counts 81 classes among the two sets' 70 and 20.
    """
    parent = Path(config.root).expanduser() if config.root is not None else default_root("paper").parent
    mpeg7 = Path(config.mpeg7).expanduser() if config.mpeg7 is not None else parent / "mpeg7"
    animals = Path(config.animals).expanduser() if config.animals is not None else parent / "animals"
    collections = [("mpeg7", _mpeg7("mpeg7", mpeg7, "mpeg7")), ("animals", _animals("animals", animals, "animals"))]
    items = [
        replace(item, name=f"{prefix}/{item.name}", cls=item.cls.casefold())
        for prefix, collection in collections
        for item in collection.items
    ]
    rejected = [
        replace(row, name=f"{prefix}/{row.name}") for prefix, collection in collections for row in collection.rejected
    ]
    kept, duplicates = _first_of_each(sorted(items, key=lambda item: item.name))
    return Collection(
        config.name, kept, (*rejected, *duplicates), sum(collection.ignored for _, collection in collections)
    )


def _limited(collection: Collection, limit: int | None) -> Collection:
    count = len(collection.items)
    if limit is None or limit >= count:
        return collection
    chosen = [collection.items[k * count // limit] for k in range(limit)]
    return replace(collection, items=tuple(chosen))


def _listed(name: str, root: Path, get: str) -> Collection:
    # Sources travel to workers that may have another working folder; no key and no table holds where the root is.
    root = root.absolute()
    paths, rejected, ignored = _pictures(root, get)
    items: list[Item] = []
    for item_name, path in _named(root, paths):
        try:
            with path.open("rb") as file:
                digest = hashlib.file_digest(file, "sha256").hexdigest()
        except OSError as error:
            message = f"{path}: cannot be read ({error.strerror})"
            rejected.append(Rejected(item_name, str(path), "unreadable", message))
            continue
        items.append(Item(item_name, class_of(_without_suffix(item_name, path)), str(path), digest))
    if not items and not rejected:
        raise DatasetError(f"{root}: no pictures here ({', '.join(sorted(PICTURES))}); {get}")
    kept, duplicates = _first_of_each(items)
    return Collection(name, kept, (*rejected, *duplicates), ignored)


def _pictures(root: Path, get: str) -> tuple[list[Path], list[Rejected], int]:
    """List the pictures below a folder, the rejected files, and the number of ignored ones."""
    if not root.is_dir():
        what = "is not a folder" if root.exists() else "does not exist"
        raise DatasetError(f"{root}: {what}; {get}")

    def unreadable(error: OSError) -> NoReturn:
        raise DatasetError(f"{error.filename}: the folder cannot be read ({error.strerror}); {get}") from error

    real = root.resolve()
    paths: list[Path] = []
    rejected: list[Rejected] = []
    ignored = 0
    for folder, folders, files in os.walk(root, onerror=unreadable):  # links to folders are not followed
        folders[:] = [name for name in folders if not name.startswith(".")]
        for file in files:
            path = Path(folder, file)
            if file.startswith(".") or path.suffix.lower() not in PICTURES:
                ignored += 1
            elif not _is_text(str(path)):
                shown = str(path).encode(errors="backslashreplace").decode()
                name = _without_suffix(shown[len(str(root)) :].lstrip("/"), path)
                rejected.append(Rejected(name, shown, "name", f"{shown}: the name is no text (UTF-8); rename the file"))
            elif not Path(os.path.realpath(path)).is_relative_to(real):
                name = _without_suffix(_normal(path.relative_to(root).as_posix()), path)
                message = f"{path}: a link that leads out of the data set; copy the picture"
                rejected.append(Rejected(name, str(path), "outside", message))
            elif _answers(path):
                paths.append(path)
            else:
                ignored += 1
    return paths, sorted(rejected, key=lambda row: row.name), ignored


def _is_text(name: str) -> bool:
    """Whether a name can be written into tables and keys: a file's name may be any bytes."""
    try:
        name.encode()
    except UnicodeEncodeError:
        return False
    return True


def _answers(path: Path) -> bool:
    """Whether opening a path returns a file or raises an error at once; a pipe or a device may block for ever."""
    try:
        return path.is_file() or not path.exists()
    except OSError:  # a folder that may be listed and not entered
        return True


def _named(root: Path, paths: Iterable[Path]) -> list[tuple[str, Path]]:
    """Give each path a unique name, and sort them. Names lose the suffix unless two would be equal without it."""
    by_file = sorted((_normal(path.relative_to(root).as_posix()), str(path), path) for path in paths)
    stems = Counter(_without_suffix(file, path) for file, _, path in by_file)
    names: list[tuple[str, Path]] = []
    taken: set[str] = set()
    for file, _, path in by_file:
        stem = _without_suffix(file, path)
        name = base = stem if stems[stem] == 1 else file
        number = 1
        while name in taken:  # the same letters composed in two ways
            number += 1
            name = f"{base}~{number}"
        taken.add(name)
        names.append((name, path))
    return sorted(names)


def _first_of_each(items: Iterable[Item]) -> tuple[tuple[Item, ...], list[Rejected]]:
    first: dict[str, Item] = {}
    duplicates: list[Rejected] = []
    for item in items:
        kept = first.setdefault(item.digest, item)
        if kept is not item:
            message = f"the same bytes as {kept.name}, which is kept; remove one of them"
            duplicates.append(Rejected(item.name, item.source, DUPLICATE, message))
    return tuple(first.values()), duplicates


def _without_suffix(name: str, path: Path) -> str:
    return name.removesuffix(_normal(path.suffix)) if path.suffix else name


def _normal(text: str) -> str:
    # Some file systems decompose accents: names, order and classes must not depend on that.
    return unicodedata.normalize("NFC", text)

"""The folder of a piece of work: every step is saved when it is made, readable by its owner alone."""

from __future__ import annotations

import os
import re
import uuid
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path

from msgspec import DecodeError, Struct, json

from riot.errors import FormatError
from studio.session.history import History
from studio.session.state import State

FORMAT, VERSION = "riot-studio", 1

DIGEST_LENGTH = 32
"""Hexadecimal digits of names: enough that no two files of a session have one."""

_DIGEST = re.compile(rf"[0-9a-f]{{{DIGEST_LENGTH}}}")
_HISTORY = "session.json"


class _Saved(Struct, frozen=True):
    """What the file of a history holds: states by digest."""

    format: str
    version: int
    states: tuple[str, ...]
    current: int
    snapshots: tuple[tuple[str, str], ...]


def digest_of(data: bytes) -> str:
    """The name of a content.

    >>> digest_of(b"")[:8]
    'e3b0c442'
    """
    return sha256(data).hexdigest()[:DIGEST_LENGTH]


class SessionFolder:
    """Files of one session: ``session.json``, and by digest ``states``, ``shapes``, ``transforms``, and ``pictures`` of
    shapes."""

    def __init__(self, path: Path) -> None:
        """The folder at ``path``, which is made if it is not there."""
        self.path = path
        for part in (path, *(path / name for name in ("states", "shapes", "transforms", "pictures", "make"))):
            part.mkdir(mode=0o700, parents=True, exist_ok=True)

    @property
    def name(self) -> str:
        """The session's name."""
        return self.path.name

    def changed(self) -> float:
        """When the history was saved last, seconds since 1970; 0 if never."""
        file = self.path / _HISTORY
        return file.stat().st_mtime if file.exists() else 0.0

    def save(self, history: History) -> None:
        """Save a history; only states that are new are written."""
        names: dict[int, str] = {}
        for state in (*history.states, *(state for _, state in history.snapshots)):
            if id(state) not in names:
                names[id(state)] = self._put("states", ".json", json.encode(state))
        saved = _Saved(
            FORMAT,
            VERSION,
            tuple(names[id(state)] for state in history.states),
            history.current,
            tuple((name, names[id(state)]) for name, state in history.snapshots),
        )
        write_private(self.path / _HISTORY, json.encode(saved))

    def load(self) -> History:
        """The history that was saved; a new one if none was. Raises `FormatError` if it is damaged."""
        file = self.path / _HISTORY
        if not file.exists():
            return History()
        try:
            saved = json.decode(file.read_bytes(), type=_Saved)
            if (saved.format, saved.version) != (FORMAT, VERSION):
                raise ValueError(f"version {saved.version}, where {VERSION} is read")
            states = {name: self._state(name) for name in {*saved.states, *(name for _, name in saved.snapshots)}}
            if not 0 <= saved.current < len(saved.states):
                raise ValueError("the current state is not one of its states")
        except (DecodeError, ValueError, OSError) as error:
            raise FormatError(f"{self.path}: a session that cannot be read ({error}); move it away") from error
        return History(
            tuple(states[name] for name in saved.states),
            saved.current,
            tuple((name, states[state]) for name, state in saved.snapshots),
        )

    def put_shape(self, document: bytes) -> str:
        """Keep a shape's document; returns its digest."""
        return self._put("shapes", ".json", document)

    def put_transform(self, text: bytes, name: str | None = None) -> str:
        """Keep a transform, under a name that it has already if one is given; returns its digest."""
        return self._put("transforms", ".riot", text, name)

    def put_picture(self, shape: str, data: bytes) -> None:
        """Keep the picture that a shape was read from, under the shape's digest."""
        self._put("pictures", "", data, shape)

    def picture(self, shape: str) -> bytes | None:
        """The picture of a shape, if it has one of several colours."""
        return self._get("pictures", "", shape) if self.has_picture(shape) else None

    def has_picture(self, shape: str) -> bool:
        """Whether there is a picture of a shape."""
        return (self.path / "pictures" / shape).exists()

    def shape(self, name: str) -> bytes:
        """The document of a shape; KeyError if there is none of this digest."""
        return self._get("shapes", ".json", name)

    def transform(self, name: str) -> bytes:
        """The text of a transform; KeyError if there is none of this digest."""
        return self._get("transforms", ".riot", name)

    def _state(self, name: str) -> State:
        return json.decode(self._get("states", ".json", name), type=State)

    def _put(self, kind: str, suffix: str, data: bytes, name: str | None = None) -> str:
        known = digest_of(data) if name is None else name
        file = self.path / kind / f"{known}{suffix}"
        if name is not None or not file.exists():
            write_private(file, data)
        return known

    def _get(self, kind: str, suffix: str, name: str) -> bytes:
        file = self.path / kind / f"{name}{suffix}"
        if not _DIGEST.fullmatch(name) or not file.exists():
            raise KeyError(f"{kind}: there is no {name}")
        return file.read_bytes()


def write_private(path: Path, data: bytes) -> None:
    """Write a file, or replace it in one step, readable by its owner alone."""
    temporary = path.with_name(f".{path.name}.{uuid.uuid4().hex}")
    try:
        descriptor = os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        with os.fdopen(descriptor, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def newest(root: Path) -> list[SessionFolder]:
    """The sessions in a folder, the one that changed last first.

    >>> from pathlib import Path
    >>> [folder.name for folder in newest(Path("nowhere"))]
    []
    """
    if not root.is_dir():
        return []
    folders = [SessionFolder(path) for path in root.iterdir() if is_name(path.name) and path.is_dir()]
    return sorted(folders, key=lambda folder: (-folder.changed(), folder.name))


def new_folder(root: Path, make_name: Callable[[], str] = lambda: uuid.uuid4().hex) -> SessionFolder:
    """A new, empty session."""
    root.mkdir(mode=0o700, parents=True, exist_ok=True)
    return SessionFolder(root / make_name()[:DIGEST_LENGTH])


def is_name(name: str) -> bool:
    """Whether a session can have this name.

    >>> is_name("../x")
    False
    """
    return _DIGEST.fullmatch(name) is not None

"""A machine that fails says nothing about a file: no verdict on it, whatever it was reading."""

from __future__ import annotations

import errno
import os
import resource
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageFile

from riot.errors import SilhouetteError
from riot.geometry import svg_document as svgfile
from riot.geometry.machine_errors import is_of_machine
from riot.geometry.picture import decode
from riot.geometry.silhouette import read

OF_MACHINE = (
    "EMFILE",
    "ENFILE",
    "ENOMEM",
    "EIO",
    "ENOSPC",
    "ESTALE",
    "ETIMEDOUT",
    "EAGAIN",
    "EROFS",
    "EDQUOT",
    "ENOTCONN",
)
OF_FILE = ("ENOENT", "ENOTDIR", "EISDIR", "EACCES", "EPERM", "ELOOP", "ENAMETOOLONG")
SQUARE = '<svg xmlns="http://www.w3.org/2000/svg"><path d="M0 0h9v9h-9z"/></svg>'


def failing(name: str) -> OSError:
    number = getattr(errno, name)
    return OSError(number, os.strerror(number), "somewhere")


@pytest.fixture
def picture(tmp_path: Path) -> Path:
    values = np.zeros((40, 40), np.uint8)
    values[10:30, 12:28] = 255
    Image.fromarray(values).save(tmp_path / "block.png")
    return tmp_path / "block.png"


def test_every_error_is_the_machines_or_the_files() -> None:
    assert all(is_of_machine(failing(name)) for name in OF_MACHINE) and is_of_machine(MemoryError())
    assert not any(is_of_machine(failing(name)) for name in OF_FILE)
    assert not any(is_of_machine(error) for error in (OSError("image file is truncated"), ValueError(), EOFError()))


@pytest.mark.parametrize("error", [MemoryError(), *map(failing, OF_MACHINE)], ids=str)
def test_a_failing_machine_is_no_verdict_on_a_picture(
    error: Exception, picture: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise error

    monkeypatch.setattr(ImageFile.ImageFile, "load", fail)
    with pytest.raises(type(error)) as caught:
        decode(picture, 10_000)
    assert caught.value is error


@pytest.mark.parametrize("name", OF_FILE)
def test_what_the_file_lacks_is_said_of_it(name: str, picture: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object, **__: object) -> None:
        raise failing(name)

    monkeypatch.setattr(Image, "open", fail)
    with pytest.raises(SilhouetteError, match="check the path") as caught:
        decode(picture, 10_000)
    assert caught.value.reason == "unreadable"


def test_a_process_without_free_descriptors_judges_no_file(picture: Path) -> None:
    """Really without: no file can be opened."""
    drawing = picture.with_name("square.svg")
    drawing.write_text(SQUARE)
    limits = resource.getrlimit(resource.RLIMIT_NOFILE)
    caught: list[OSError] = []
    resource.setrlimit(resource.RLIMIT_NOFILE, (0, limits[1]))
    try:
        for function in (lambda: decode(picture, 10_000), lambda: svgfile.load(drawing)):
            try:
                function()
            except OSError as error:
                caught.append(error)
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, limits)
    assert [error.errno for error in caught] == [errno.EMFILE, errno.EMFILE]
    assert len(read(picture).points) > 100 and svgfile.load(drawing).tag.endswith("svg")


def test_a_drawing_is_not_taken_for_a_picture_because_the_machine_failed_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawing = tmp_path / "square.svg"
    drawing.write_text(SQUARE)
    opened, left = Path.open, 1

    def fail_once(path: Path, *arguments: str) -> object:
        nonlocal left
        left -= 1
        if left == 0:
            raise failing("EMFILE")
        return opened(path, *arguments)

    monkeypatch.setattr(Path, "open", fail_once)
    with pytest.raises(OSError, match=os.strerror(errno.EMFILE)):
        read(drawing)
    assert read(drawing).name == "square"


def test_a_drawing_on_a_failing_disk_is_not_judged(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drawing = tmp_path / "square.svg"
    drawing.write_text(SQUARE)

    class Failing:
        def __enter__(self) -> Failing:
            return self

        def __exit__(self, *_: object) -> None:
            pass

        def read(self, _: int) -> bytes:
            raise failing("EIO")

    monkeypatch.setattr(Path, "open", lambda *_: Failing())
    with pytest.raises(OSError, match=os.strerror(errno.EIO)):
        svgfile.load(drawing)
    with pytest.raises(SilhouetteError, match="No such file"):
        svgfile.load(tmp_path / "absent.svg")

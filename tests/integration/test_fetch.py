"""Fetching from an archive served on the loopback interface: checked, complete or nothing."""

from __future__ import annotations

import contextlib
import io
import resource
import threading
import zipfile
from collections.abc import Iterator
from functools import partial
from http.server import BaseHTTPRequestHandler, SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from pipeline.datasets import fetch
from pipeline.datasets.collection import DatasetConfig, DatasetError, collect
from pipeline.fetch import main

NAMES = ("Bone-1", "apple-1", "apple-2")


class Server:
    """Serves a folder and counts the requests."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.requests: list[str] = []
        requests = self.requests

        class Handler(SimpleHTTPRequestHandler):
            def log_message(self, *_: object) -> None:
                requests.append(self.path)

        self.http = ThreadingHTTPServer(("127.0.0.1", 0), partial(Handler, directory=str(folder)))
        self.thread = threading.Thread(target=self.http.serve_forever, daemon=True)
        self.thread.start()

    def url(self, name: str) -> str:
        return f"http://127.0.0.1:{self.http.server_address[1]}/{name}"

    def close(self) -> None:
        self.http.shutdown()
        self.http.server_close()
        self.thread.join()


@pytest.fixture
def server(tmp_path: Path) -> Iterator[Server]:
    (tmp_path / "www").mkdir()
    running = Server(tmp_path / "www")
    yield running
    running.close()


def pixels(number: int) -> np.ndarray:
    rows, columns = np.mgrid[:40, :50]
    return ((columns - 25) ** 2 + (rows - 20) ** 2 <= (10 + number) ** 2).astype(np.uint8)


def encoded(values: np.ndarray, form: str) -> bytes:
    stream = io.BytesIO()
    Image.fromarray(values * 255).save(stream, form)
    return stream.getvalue()


@pytest.fixture
def manifest(tmp_path: Path) -> Path:
    folder = tmp_path / "originals"
    folder.mkdir()
    for number, name in enumerate(NAMES):
        (folder / f"{name}.png").write_bytes(encoded(pixels(number), "PNG"))
    assert fetch.write_manifest(folder, tmp_path / "manifest.csv") == 3
    return tmp_path / "manifest.csv"


def pack(server: Server, members: dict[str, bytes], name: str = "set.zip") -> str:
    with zipfile.ZipFile(server.folder / name, "w") as archive:
        for member, data in members.items():
            archive.writestr(member, data)
    return server.url(name)


def good() -> dict[str, bytes]:
    """The same pictures in another format, letter case and folder, with bystanders."""
    members = {f"original/{name.upper()}.GIF": encoded(pixels(n), "GIF") for n, name in enumerate(NAMES)}
    return members | {"original/readme.txt": b"hello", "__MACOSX/._apple-1.png": b"", "extra-1.gif": b"not listed"}


def nothing_left(folder: Path) -> bool:
    return not folder.parent.exists()


def test_fetch_and_mine(server: Server, manifest: Path, tmp_path: Path) -> None:
    url = pack(server, good())
    target = tmp_path / "cache" / "mpeg7"
    assert fetch.fetch(target, [url], manifest)
    assert sorted(path.name for path in target.iterdir()) == ["Bone-1.gif", "apple-1.gif", "apple-2.gif"]
    assert [item.cls for item in collect(DatasetConfig("m", "mpeg7", root=str(target))).items] == [
        "Bone", "apple", "apple"
    ]  # fmt: skip
    asked = len(server.requests)
    assert asked > 0
    assert not fetch.fetch(target, [url], manifest)
    assert len(server.requests) == asked  # the second time nothing is downloaded


def test_next_address_is_tried(server: Server, manifest: Path, tmp_path: Path) -> None:
    url = pack(server, good())
    assert fetch.fetch(tmp_path / "set", [server.url("absent.zip"), url], manifest)
    assert "/absent.zip" in server.requests


@pytest.mark.parametrize("fault", ["altered", "missing", "no picture", "other size"])
def test_wrong_pictures_are_named_and_nothing_is_kept(
    server: Server, manifest: Path, tmp_path: Path, fault: str
) -> None:
    members = good()
    name = "original/APPLE-2.GIF"
    changed = pixels(2)
    changed[0, 0] = 1
    if fault == "missing":
        del members[name]
    elif fault == "no picture":
        members[name] = b"GIF89a"
    else:
        members[name] = encoded(changed if fault == "altered" else pixels(2)[:-1], "GIF")
    target = tmp_path / "cache" / "set"
    with pytest.raises(DatasetError, match=r"apple-2 is .*nothing was kept") as caught:
        fetch.fetch(target, [pack(server, members)], manifest)
    assert "apple-1" not in str(caught.value)
    assert nothing_left(target)


def test_archive_cannot_write_elsewhere(server: Server, manifest: Path, tmp_path: Path) -> None:
    members = {f"../../{name}.gif": encoded(pixels(n), "GIF") for n, name in enumerate(NAMES)}
    members["../../evil.gif"] = b"evil"
    assert fetch.fetch(tmp_path / "deep" / "er" / "set", [pack(server, members)], manifest)
    assert not list(tmp_path.rglob("evil*"))
    assert not [path for path in tmp_path.rglob("*.gif") if path.parent.name != "set"]


def test_damaged_archive_and_no_answer(server: Server, manifest: Path, tmp_path: Path) -> None:
    url = pack(server, good())
    whole = (server.folder / "set.zip").read_bytes()
    (server.folder / "set.zip").write_bytes(whole[:-40])
    target = tmp_path / "cache" / "set"
    with pytest.raises(DatasetError, match="unpacked"):
        fetch.fetch(target, [url], manifest)
    assert nothing_left(target)
    (server.folder / "set.zip").write_bytes(whole.replace(b"GIF89a", b"GIF89b").replace(b"GIF87a", b"GIF87b"))
    with pytest.raises(DatasetError):
        fetch.fetch(target, [url], manifest)
    with pytest.raises(DatasetError, match=r"no address.*dataset\.root"):
        fetch.fetch(target, [server.url("absent.zip"), "http://127.0.0.1:9/x.zip"], manifest, timeout=2.0)
    assert not target.parent.exists()


def test_a_users_folder_is_left_alone(server: Server, manifest: Path, tmp_path: Path) -> None:
    target = tmp_path / "mine"
    target.mkdir()
    (target / "letter.txt").write_text("mine")
    with pytest.raises(DatasetError, match="remove or rename"):
        fetch.fetch(target, [pack(server, good())], manifest)
    assert [path.name for path in target.iterdir()] == ["letter.txt"]
    with pytest.raises(DatasetError, match="not a folder"):
        fetch.fetch(target / "letter.txt", [pack(server, good())], manifest)
    with pytest.raises(DatasetError, match="cannot be written"):
        fetch.fetch(target / "letter.txt" / "set", [pack(server, good())], manifest)
    assert (target / "letter.txt").read_text() == "mine"
    assert server.requests == []


def test_command(server: Server, manifest: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    # The project's own manifest wants 1,400 pictures; these three are none of them, or altered.
    assert main(["mpeg7", "--to", str(tmp_path / "set"), "--from", pack(server, good())]) == 2
    assert "is missing" in capsys.readouterr().err
    listing = tmp_path / "list.csv"
    assert main(["manifest", str(tmp_path / "originals"), "--to", str(listing)]) == 0
    assert listing.read_bytes() == manifest.read_bytes()
    assert main(["manifest", str(tmp_path / "absent")]) == 2
    (tmp_path / "empty").mkdir()
    (tmp_path / "originals" / "torn-1.png").write_bytes(b"no picture")
    for folder in ("empty", "originals"):
        assert main(["manifest", str(tmp_path / folder), "--to", str(listing)]) == 2
    assert listing.read_bytes() == manifest.read_bytes()  # a list is replaced whole or not at all


def test_the_manifest_of_mpeg7() -> None:
    entries = fetch.read_manifest(fetch.MPEG7_MANIFEST)
    assert len({entry.name.casefold() for entry in entries}) == len(entries) == 1400
    assert len({entry.name.rpartition("-")[0] for entry in entries}) == 70
    assert all(len(entry.sha256) == 64 and entry.width > 0 and entry.height > 0 for entry in entries)


@pytest.mark.parametrize("method", [zipfile.ZIP_DEFLATED, zipfile.ZIP_LZMA, zipfile.ZIP_BZIP2, zipfile.ZIP_STORED])
def test_any_damage_of_an_archive_is_told_as_one(server: Server, manifest: Path, tmp_path: Path, method: int) -> None:
    path = server.folder / "packed.zip"
    with zipfile.ZipFile(path, "w", method) as archive:
        for member, data in good().items():
            archive.writestr(member, data)
    whole = path.read_bytes()
    for position in range(0, len(whole), 29):
        path.write_bytes(whole[:position] + bytes([whole[position] ^ 255]) + whole[position + 1 :])
        try:
            fetch.fetch(tmp_path / f"set-{position}", [server.url("packed.zip")], manifest)
        except DatasetError as error:
            assert ";" in str(error)


def test_an_archive_that_unpacks_to_too_much_is_not_unpacked(server: Server, manifest: Path, tmp_path: Path) -> None:
    limits = fetch.DownloadLimits(unpacked=1_000_000)
    members = good() | {"apple-1.gif": bytes(1_000_001)}
    with zipfile.ZipFile(server.folder / "bomb.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        for member, data in members.items():
            archive.writestr(member, data)
    assert (server.folder / "bomb.zip").stat().st_size < 10_000
    with pytest.raises(DatasetError, match="more than 1000000 bytes"):
        fetch.fetch(tmp_path / "cache" / "set", [server.url("bomb.zip")], manifest, limits=limits)
    assert nothing_left(tmp_path / "cache" / "set")


class Endless(BaseHTTPRequestHandler):
    """Announces little or nothing, and sends until nobody listens."""

    def do_GET(self) -> None:
        self.send_response(200)
        self.end_headers()
        with contextlib.suppress(OSError):
            while True:
                self.wfile.write(bytes(2**16))

    def log_message(self, *_: object) -> None:
        pass


def test_a_download_without_end_is_stopped_and_the_next_address_tried(
    server: Server, manifest: Path, tmp_path: Path
) -> None:
    limits = fetch.DownloadLimits(download=1_000_000)
    with ThreadingHTTPServer(("127.0.0.1", 0), Endless) as endless:
        thread = threading.Thread(target=endless.serve_forever)
        thread.start()
        url = f"http://127.0.0.1:{endless.server_address[1]}/set.zip"
        try:
            with pytest.raises(DatasetError, match=r"set.zip .more than 1000000 bytes; this is another file"):
                fetch.fetch(tmp_path / "cache" / "set", [url], manifest, limits=limits)
            assert nothing_left(tmp_path / "cache" / "set")
            assert fetch.fetch(tmp_path / "cache" / "set", [url, pack(server, good())], manifest, limits=limits)
        finally:
            endless.shutdown()
            thread.join()
    assert [path.name for path in (tmp_path / "cache").iterdir()] == ["set"]


def test_a_download_may_be_as_long_as_the_limit(server: Server, manifest: Path, tmp_path: Path) -> None:
    url = pack(server, good())
    size = (server.folder / "set.zip").stat().st_size
    with pytest.raises(DatasetError, match=f"more than {size - 1} bytes"):
        fetch.fetch(tmp_path / "cache" / "set", [url], manifest, limits=fetch.DownloadLimits(download=size - 1))
    assert fetch.fetch(tmp_path / "cache" / "set", [url], manifest, limits=fetch.DownloadLimits(download=size))


def test_a_file_that_the_disk_does_not_take_is_not_blamed_on_the_address(
    server: Server, manifest: Path, tmp_path: Path
) -> None:
    url = pack(server, good())
    usual = resource.getrlimit(resource.RLIMIT_FSIZE)
    try:
        resource.setrlimit(resource.RLIMIT_FSIZE, (100, usual[1]))  # bytes that any file may have from here on
        with pytest.raises(DatasetError, match=r"set: cannot be written .File too large"):
            fetch.fetch(tmp_path / "cache" / "set", [url, url], manifest)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, usual)
    assert server.requests == ["/set.zip"] and nothing_left(tmp_path / "cache" / "set")

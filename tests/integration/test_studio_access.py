"""Who may ask the studio's server, and what it refuses to read."""

from __future__ import annotations

import io
from collections.abc import Iterator
from pathlib import Path

import pytest
from PIL import Image
from starlette.testclient import TestClient
from starlette.websockets import WebSocketDisconnect
from studio_client import HOUSE, ORIGIN, PORT, SOCKETS, TOKEN, Tab, client, client_of, put, session

from studio.server.inputs import MAX_UPLOAD

__all__ = ["client", "session"]


def test_without_the_token_nothing_is_answered(tmp_path: Path) -> None:
    with client_of(tmp_path) as stranger:
        for path in ("/", "/api/sessions", "/static/index.html", "/?token=wrong", f"/api/sessions?token={TOKEN}"):
            answer = stranger.get(path)
            assert answer.status_code == 403, path
            assert "riot studio" in answer.text
        with pytest.raises(WebSocketDisconnect), stranger.websocket_connect(f"{SOCKETS}/x", headers={"origin": ORIGIN}):
            pass


def test_the_token_becomes_a_cookie_that_scripts_and_other_sites_do_not_get(tmp_path: Path) -> None:
    with client_of(tmp_path) as browser:
        answer = browser.get(f"/?token={TOKEN}")
        cookie = answer.headers["set-cookie"].lower()
        assert answer.status_code == 303 and answer.headers["location"] == "/"
        assert f"riot-studio-{PORT}=" in cookie and "httponly" in cookie and "samesite=strict" in cookie
        page = browser.get("/")
        assert page.status_code == 200
        policy = page.headers["content-security-policy"]
        assert "default-src 'self'" in policy and "unsafe" not in policy and "http" not in policy


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1", "127.0.0.1:80", f"evil.example:{PORT}", ""])
def test_another_name_of_the_server_is_refused(client: TestClient, host: str) -> None:
    """A name that an attacker points to this machine (DNS rebinding)."""
    assert client.get("/api/sessions", headers={"host": host}).status_code == 421


@pytest.mark.parametrize("origin", ["http://evil.example", "null", f"http://127.0.0.1:{PORT + 1}", "https://127.0.0.1"])
def test_pages_of_other_sites_are_refused(client: TestClient, session: str, origin: str) -> None:
    headers = {"origin": origin}
    assert client.get("/api/sessions", headers=headers).status_code == 403
    assert client.post("/api/sessions", headers=headers).status_code == 403
    with pytest.raises(WebSocketDisconnect), client.websocket_connect(f"{SOCKETS}/{session}", headers=headers):
        pass


def test_what_changes_something_must_say_where_it_comes_from(tmp_path: Path) -> None:
    with client_of(tmp_path) as browser:
        browser.get(f"/?token={TOKEN}")
        assert browser.post("/api/sessions").status_code == 403
        assert browser.get("/api/sessions").status_code == 200


# What is sent


@pytest.mark.parametrize(
    "path",
    [
        "/static/../command.py",
        "/static/%2e%2e/command.py",
        "/static//etc/passwd",
        "/api/sessions/../../etc/scene/passwd",
        "/api/sessions/..%2f..%2fetc/scene/passwd",
        "/api/sessions/{session}/scene/..%2f..%2fsession.json",
        "/api/sessions/{session}/make/..%2f..%2f/parts/session.json",
        "/api/sessions/{session}/make/" + "a" * 32 + "/parts/..%2f..%2f..%2fsession.json",
        "/api/sessions/{session}/download/..%2f..%2fsession.json",
        "/api/sessions/{session}/download/stl?make=../..",
    ],
)
def test_no_path_of_a_browser_is_opened(client: TestClient, session: str, path: str) -> None:
    answer = client.get(path.format(session=session))
    assert answer.status_code in (404, 409), answer.text
    assert "riot-studio" not in answer.text


def test_a_file_that_is_too_large_is_refused_before_it_is_read(client: TestClient, session: str) -> None:
    def unannounced() -> Iterator[bytes]:
        for _ in range(MAX_UPLOAD // 1_000_000 + 1):
            yield bytes(1_000_000)

    for data in (bytes(MAX_UPLOAD + 1), unannounced()):
        answer = client.put(f"/api/sessions/{session}/input/p", content=data)
        assert answer.status_code == 413 and "make it smaller" in answer.json()["words"]


def blank() -> bytes:
    stream = io.BytesIO()
    Image.new("RGB", (64, 64), "white").save(stream, "PNG")
    return stream.getvalue()


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "bad"),
        (b"\x00" * 5000, "bad"),
        (b"<svg", "bad"),
        (b'{"format": "riot-transform"', "bad is not a .riot file"),
        (b'{"format": "riot-transform", "version": 2}', "bad is damaged"),
        (blank(), "bad"),
    ],
)
def test_a_file_that_is_no_shape_is_told_by_its_name(client: TestClient, session: str, data: bytes, words: str) -> None:
    answer = put(client, session, "p", data, "../../bad.png")
    assert answer.status_code == 422
    assert words in answer.json()["words"] and "/tmp" not in answer.json()["words"]


def test_messages_that_are_not_understood_end_nothing(client: TestClient, session: str) -> None:
    with client.websocket_connect(f"{SOCKETS}/{session}") as socket:
        tab = Tab(socket)
        tab.until("session")
        for text in ("", "{", '{"type":"bogus","seq":1}', '{"type":"undo"}', "[" * 5000):
            socket.send_text(text)
            assert "not understood" in tab.until("refused")["words"]
        assert "no transform yet" in tab.edit(kind="weight", weight=2.0)["words"]
        assert "no collection" in tab.ask("partners", type="partners", shape=1)["words"]
        assert "no transform yet" in tab.ask("made", type="make")["words"]


def test_there_is_no_session_of_another_name(client: TestClient) -> None:
    for name in ("a" * 32, "nothing"):
        with pytest.raises(WebSocketDisconnect), client.websocket_connect(f"{SOCKETS}/{name}"):
            pass
        assert client.get(f"/api/sessions/{name}/download/riot").status_code == 404
        assert put(client, name, "p", HOUSE).status_code == 404


# What is done

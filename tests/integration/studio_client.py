"""A client of the studio's server, and a tab of a browser, for tests."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from starlette.testclient import TestClient, WebSocketTestSession

from studio.live.studio import Studio
from studio.server.app import make_app

PORT, TOKEN = 4321, "a-token-of-this-test"
ORIGIN = f"http://127.0.0.1:{PORT}"
SOCKETS = f"ws://127.0.0.1:{PORT}/ws"
HOUSE = '<svg xmlns="http://www.w3.org/2000/svg"><path d="M0 2L2 0L4 2V5H0Z"/></svg>'
KITE = '<svg xmlns="http://www.w3.org/2000/svg"><path d="M0 3L-2 6L0 8L2 6Z"/></svg>'


def client_of(root: Path, run: Path | None = None) -> TestClient:
    return TestClient(make_app(Studio(root, run), PORT, TOKEN), base_url=ORIGIN, follow_redirects=False)


@pytest.fixture(scope="module")
def client(tmp_path_factory: pytest.TempPathFactory) -> Iterator[TestClient]:
    """A client with the cookie; one server for all tests of this file that start none."""
    with client_of(tmp_path_factory.mktemp("studio")) as client:
        assert client.get(f"/?token={TOKEN}").status_code == 303
        client.headers["origin"] = ORIGIN
        yield client


@pytest.fixture
def session(client: TestClient) -> str:
    return str(client.post("/api/sessions").json()["id"])


class Tab:
    """A tab of a browser: it sends requests, and reads news until those that it waits for."""

    def __init__(self, socket: WebSocketTestSession) -> None:
        self.socket, self.seq, self.seen = socket, 0, list[dict[str, Any]]()

    def until(self, *kinds: str, seq: int | None = None) -> dict[str, Any]:
        while True:
            message: dict[str, Any] = self.socket.receive_json()
            self.seen.append(message)
            if message["type"] in kinds and (seq is None or message["seq"] == seq):
                return message

    def ask(self, *kinds: str, **request: Any) -> dict[str, Any]:
        self.seq += 1
        self.socket.send_json({**request, "seq": self.seq})
        return self.until(*kinds, "refused", "problem", seq=self.seq)

    def edit(self, phase: str = "release", **edit: Any) -> dict[str, Any]:
        return self.ask("transform", type="edit", phase=phase, edit=edit)


def put(client: TestClient, session: str, side: str, data: bytes | str, name: str = "a.svg") -> Any:
    return client.put(f"/api/sessions/{session}/input/{side}", params={"name": name}, content=data)


def given(client: TestClient, session: str, tab: Tab) -> dict[str, Any]:
    """Give both shapes; returns the scene of the bent transform."""
    assert put(client, session, "p", HOUSE, "house.svg").status_code == 200
    assert put(client, session, "q", KITE, "kite.svg").status_code == 200
    while (message := tab.until("transform"))["draft"]:
        pass
    scene: dict[str, Any] = message["scene"]
    return scene


# Who may ask

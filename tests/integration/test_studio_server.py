"""The studio's server as browsers ask it: what they send, what they hear; and what stays when it ends."""

from __future__ import annotations

import base64
import io
import json
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from PIL import Image, ImageDraw
from starlette.testclient import TestClient
from studio_client import KITE, ORIGIN, SOCKETS, TOKEN, Tab, client, client_of, given, put, session

import riot
from riot.transform.riot_file import from_json, to_json

__all__ = ["client", "session"]

STL = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def test_two_shapes_become_a_transform_that_edits_change_and_undo_brings_back(client: TestClient, session: str) -> None:
    with client.websocket_connect(f"{SOCKETS}/{session}") as socket:
        tab = Tab(socket)
        first = given(client, session, tab)
        assert first["exact"] and first["p"]["name"] == "house" and len(first["pieces"]) >= 3
        at = first["p"]["input"][:2]
        draft = tab.edit("move", kind="keep", side="p", points=at)
        assert draft["draft"] and draft["scene"]["exact"]
        kept = tab.edit(kind="keep", side="p", points=at)
        assert not kept["draft"] and kept["scene"]["certificate"]["passed"]
        state = next(message for message in reversed(tab.seen) if message["type"] == "session")
        assert state["undo"] == "keep" and len(state["pins"]["p"]) == 1
        undone = tab.ask("session", type="undo")
        assert undone["redo"] == "keep" and undone["transform"] == first["id"] and undone["pins"]["p"] == []
        assert tab.ask("session", type="redo")["transform"] == kept["scene"]["id"]


def test_parts_are_painted_softer_and_erased(client: TestClient, session: str) -> None:
    with client.websocket_connect(f"{SOCKETS}/{session}") as socket:
        tab = Tab(socket)
        before = given(client, session, tab)

        def regions() -> list[dict[str, Any]]:
            state = next(message for message in reversed(tab.seen) if message["type"] == "session")
            painted: list[dict[str, Any]] = state["stiff"]["p"]
            return painted

        across = [-0.4, 0.0, 0.4, 0.0]
        soft = tab.edit(kind="stiff", side="p", stroke=across, radius=0.1, factor=0.05)
        assert soft["scene"]["p"]["bent"] != before["p"]["bent"]
        assert [region["factor"] for region in regions()] == [0.05]
        assert "nothing is painted" in tab.edit(kind="erase", side="q", stroke=across, radius=0.1)["words"]
        assert tab.edit(kind="erase", side="p", stroke=[0.0, -0.3, 0.0, 0.3], radius=0.1)["type"] == "transform"
        assert [region["factor"] for region in regions()] == [0.05, 0.05]
        assert tab.edit(kind="erase", side="p", stroke=across, radius=0.3)["scene"]["exact"]
        assert regions() == []


def test_shapes_that_must_be_bent_show_a_draft_soon_and_then_the_best(client: TestClient, session: str) -> None:
    with client.websocket_connect(f"{SOCKETS}/{session}") as socket:
        tab = Tab(socket)
        for side, path in (("p", "M0 5H4V4H1V0H0Z"), ("q", "M0 5H5V4H3V0H2V4H0Z")):
            put(client, session, side, f'<svg xmlns="http://www.w3.org/2000/svg"><path d="{path}"/></svg>')
        drafted = tab.until("transform", "problem")
        assert drafted["type"] == "transform" and drafted["draft"] and "bent" in drafted["scene"]["p"]
        assert drafted["scene"]["certificate"]["passed"]
        best = tab.until("transform", "problem")
        assert not best["draft"] and best["scene"]["certificate"]["passed"]
        tab.until("motion")
        outline = best["scene"]["p"]["bent"]
        kept = tab.edit(kind="keep", side="p", points=outline[: len(outline) // 8 * 2])
        told = tab.until("problem", seq=tab.seq)
        assert kept["scene"]["certificate"]["passed"] and told["side"] == "p" and len(told["where"]) >= 2
        assert "another way to cut" in told["words"].lower() and "trunk" in told["words"]
        state = next(message for message in reversed(tab.seen) if message["type"] == "session")
        assert state["undo"] == "keep" and state["pins"]["p"]


def test_what_cannot_be_is_told_with_the_place_and_changes_nothing(client: TestClient, session: str) -> None:
    with client.websocket_connect(f"{SOCKETS}/{session}") as socket:
        tab = Tab(socket)
        scene = given(client, session, tab)
        points = scene["p"]["input"]
        half = len(points) // 4 * 2
        line = [*points[:2], *points[half : half + 2]]
        told = tab.edit(kind="draw", side="p", line=line)
        assert told["type"] == "problem" and told["side"] == "p" and told["words"]
        assert tab.ask("session", type="snapshot", name="after")["transform"] == scene["id"]


def test_the_file_that_is_downloaded_is_the_transform_that_is_shown(client: TestClient, session: str) -> None:
    with client.websocket_connect(f"{SOCKETS}/{session}") as socket:
        tab = Tab(socket)
        scene = given(client, session, tab)
        tab.until("motion")
        answer = client.get(f"/api/sessions/{session}/download/riot")
        transform = from_json(answer.text)
        assert riot.transform.certificate.certify(transform).passed and transform.plan is not None
        assert len(transform) == len(scene["pieces"])
        for i, piece in enumerate(transform.pieces):
            assert scene["pieces"][i]["length"] == pytest.approx(piece.length, abs=1e-5)
        assert client.get(f"/api/sessions/{session}/download/stl").status_code == 409
        again = client.post("/api/sessions").json()["id"]
        assert put(client, again, "p", to_json(transform), "x.riot").status_code == 200
        assert client.get(f"/api/sessions/{again}/download/riot").text == answer.text


@pytest.mark.parametrize("phase", ["move", "release"])
def test_an_error_that_nobody_foresaw_is_told_and_ends_nothing(
    client: TestClient, session: str, phase: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    with client.websocket_connect(f"{SOCKETS}/{session}") as socket:
        tab = Tab(socket)
        scene = given(client, session, tab)
        with monkeypatch.context() as patched:
            patched.setattr("studio.live.session.change", len)  # which takes one argument
            assert "TypeError" in tab.edit(phase, kind="weight", weight=2.0)["words"]
        assert tab.edit(phase, kind="keep", side="p", points=scene["p"]["input"][:2])["type"] == "transform"


def test_two_tabs_see_the_same(client: TestClient, session: str) -> None:
    with (
        client.websocket_connect(f"{SOCKETS}/{session}") as first,
        client.websocket_connect(f"{SOCKETS}/{session}") as second,
    ):
        one, two = Tab(first), Tab(second)
        given(client, session, one)
        made = one.edit(kind="weight", weight=None)
        seen = two.until("transform", seq=one.seq)
        assert seen["scene"] == made["scene"]
        two.socket.send_json({"type": "undo", "seq": 99})
        assert one.until("session", seq=99)["transform"] == two.until("session", seq=99)["transform"]


def test_a_server_that_starts_again_has_every_step(tmp_path: Path) -> None:
    with client_of(tmp_path) as browser:
        browser.get(f"/?token={TOKEN}")
        browser.headers["origin"] = ORIGIN
        session = browser.post("/api/sessions").json()["id"]
        with browser.websocket_connect(f"{SOCKETS}/{session}") as socket:
            tab = Tab(socket)
            scene = given(browser, session, tab)
            tab.edit(kind="keep", side="p", points=scene["p"]["input"][:2])
            tab.ask("session", type="snapshot", name="first")
            before = next(message for message in reversed(tab.seen) if message["type"] == "session")
    with client_of(tmp_path) as browser:
        browser.get(f"/?token={TOKEN}")
        listed = browser.get("/api/sessions").json()
        assert listed["current"] == session and listed["sessions"][0]["p"] == "house"
        with browser.websocket_connect(f"{SOCKETS}/{session}", headers={"origin": ORIGIN}) as socket:
            tab = Tab(socket)
            after = tab.until("session")
            assert tab.until("transform")["scene"]["id"] == before["transform"]
            same = ("undo", "pins", "transform", "weight", "p", "q")
            assert {name: after[name] for name in same} == {name: before[name] for name in same}
            assert [kept["name"] for kept in after["snapshots"]] == ["first"]
            assert tab.ask("session", type="undo")["transform"] == scene["id"]


def test_alternatives_come_one_by_one_and_one_is_chosen(client: TestClient, session: str) -> None:
    with client.websocket_connect(f"{SOCKETS}/{session}") as socket:
        tab = Tab(socket)
        given(client, session, tab)
        end = tab.ask("alternatives_end", type="alternatives")
        found = [message for message in tab.seen if message["type"] == "alternative"]
        assert end["count"] == len(found) > 1
        other = found[-1]["transform"]
        assert tab.edit(kind="choose", transform=other)["scene"]["id"] == other


def test_a_puzzle_is_made_certified_and_downloaded(client: TestClient, session: str) -> None:
    pytest.importorskip("manifold3d")
    with client.websocket_connect(f"{SOCKETS}/{session}") as socket:
        tab = Tab(socket)
        scene = given(client, session, tab)
        told = tab.ask("made", "made_not", type="make", settings={"size_mm": 5.0})
        assert told["type"] == "problem" and "size_mm" in told["words"]
        made = tab.ask("made", "made_not", type="make", settings={"size_mm": 150.0}, fix=True)
        assert made["passed"] and {part["kind"] for part in made["parts"]} >= {"piece"}
        assert all(finding["severity"] != "failure" for finding in made["findings"])
        pieces = [part for part in made["parts"] if part["kind"] == "piece"]
        assert {part["upside_down"] for part in pieces} == {False, True}
        for part in pieces:  # as the file says, turned over, it is the piece that is shown
            outline = made["scale"] * np.array(scene["pieces"][part["piece"]]["outline"]).reshape(-1, 2)
            data = np.frombuffer(client.get(part["url"]).content[84:], dtype=STL)["corners"].reshape(-1, 3)
            flat = data[:, :2] * ([1.0, -1.0] if part["upside_down"] else [1.0, 1.0])
            body = shapely.MultiPoint(flat).convex_hull
            assert body.symmetric_difference(shapely.Polygon(outline).convex_hull).area < 0.2 * body.area
        part = made["parts"][0]
        stl = client.get(part["url"])
        archive = client.get(f"/api/sessions/{session}/download/stl", params={"make": made["key"]})
        with zipfile.ZipFile(io.BytesIO(archive.content)) as files:
            assert files.read(f"{part['name']}.stl") == stl.content


def test_a_photo_of_a_shape_is_an_input(client: TestClient, session: str) -> None:
    picture = Image.new("RGB", (300, 200), "white")
    ImageDraw.Draw(picture).ellipse((60, 30, 240, 170), fill=(90, 60, 30))
    stream = io.BytesIO()
    picture.save(stream, "JPEG", quality=80)
    with client.websocket_connect(f"{SOCKETS}/{session}") as socket:
        tab = Tab(socket)
        tab.until("session")
        assert put(client, session, "q", stream.getvalue(), "C:\\my pictures\\egg.jpeg").json() == {"doubts": []}
        assert tab.until("session")["q"]["name"] == "egg"


def two_coloured() -> bytes:
    """A house whose left half is red and whose right half is blue."""
    picture = Image.new("RGB", (240, 240), "white")
    drawing = ImageDraw.Draw(picture)
    drawing.polygon([(20, 100), (120, 20), (120, 220), (20, 220)], fill=(220, 30, 30))
    drawing.polygon([(120, 20), (220, 100), (220, 220), (120, 220)], fill=(30, 30, 220))
    stream = io.BytesIO()
    picture.save(stream, "PNG")
    return stream.getvalue()


def test_pieces_have_the_colours_of_a_picture(client: TestClient, session: str) -> None:
    with client.websocket_connect(f"{SOCKETS}/{session}") as socket:
        tab = Tab(socket)
        put(client, session, "p", two_coloured(), "house.png")
        put(client, session, "q", KITE, "kite.svg")
        while (message := tab.until("transform"))["draft"]:
            pass
        scene = message["scene"]
        told = next(message for message in reversed(tab.seen) if message["type"] == "session")
        assert (told["p"]["colours"], told["q"]["colours"]) == (True, False)
        address = f"/api/sessions/{session}/textures/{scene['id']}"
        painted = client.get(address).json()
        assert set(painted) == {"p"} and len(painted["p"]) == len(scene["pieces"])
        assert client.get(f"{address[:-1]}{'0' if address[-1] != '0' else '1'}").status_code == 404
    transform = from_json(client.get(f"/api/sessions/{session}/download/riot").text)
    pose, red, blue = transform.pose(0.0), [], []
    for k, texture in enumerate(painted["p"]):
        with Image.open(io.BytesIO(base64.b64decode(texture["href"].partition(",")[2]))) as image:
            pixels = np.asarray(image).astype(int)
        x0, y0, x1, y1 = texture["box"]
        rows, columns = np.indices(pixels.shape[:2])
        points = np.column_stack(
            [
                x0 + (columns.ravel() + 0.5) * (x1 - x0) / pixels.shape[1],
                y1 - (rows.ravel() + 0.5) * (y1 - y0) / pixels.shape[0],
            ]
        )
        inside = shapely.contains_xy(shapely.Polygon(transform.pieces[k].polygon).buffer(-0.02), points)
        x = pose.place(k, points[inside])[:, 0]
        is_red = pixels.reshape(-1, 3)[inside, 0] > pixels.reshape(-1, 3)[inside, 2]
        red.append(x[is_red])
        blue.append(x[~is_red])
    left, right = np.concatenate(red), np.concatenate(blue)
    assert len(left) and len(right) and np.quantile(left, 0.99) < np.quantile(right, 0.01) + 0.05


def test_a_picture_of_one_colour_gives_no_textures(client: TestClient, session: str) -> None:
    with client.websocket_connect(f"{SOCKETS}/{session}") as socket:
        tab = Tab(socket)
        scene = given(client, session, tab)
        told = next(message for message in reversed(tab.seen) if message["type"] == "session")
        assert not told["p"]["colours"] and not told["q"]["colours"]
        assert client.get(f"/api/sessions/{session}/textures/{scene['id']}").json() == {}
        flat = Image.new("RGB", (300, 200), "white")
        ImageDraw.Draw(flat).ellipse((60, 30, 240, 170), fill=(90, 60, 30))
        stream = io.BytesIO()
        flat.save(stream, "JPEG", quality=80)
        put(client, session, "q", stream.getvalue(), "egg.jpeg")
        while (told := tab.until("session"))["q"]["name"] != "egg":
            pass
        assert not told["q"]["colours"]


def test_a_picture_that_may_be_read_wrongly_is_taken_with_the_reason(client: TestClient, session: str) -> None:
    picture = Image.new("L", (200, 200), 255)
    drawing = ImageDraw.Draw(picture)
    drawing.ellipse((10, 60, 90, 140), fill=0)
    drawing.ellipse((110, 62, 186, 138), fill=0)
    stream = io.BytesIO()
    picture.save(stream, "PNG")
    (doubt,) = put(client, session, "p", stream.getvalue(), "two.png").json()["doubts"]
    assert "of the object is kept" in doubt


def test_what_can_be_set_has_a_range_and_a_meaning(client: TestClient) -> None:
    listed = json.loads(client.get("/api/settings").content)
    settings = {setting["name"]: setting for setting in listed["settings"]}
    assert settings["size_mm"]["least"] == 30.0 and settings["size_mm"]["meaning"]
    for preset in listed["presets"]:
        for name, value in preset["values"].items():
            setting = settings[name]
            if setting["choices"]:
                assert value in setting["choices"]
            else:
                assert setting["least"] <= value <= setting["greatest"]

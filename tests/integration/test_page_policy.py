"""Pages say what a browser may run: their own scripts do run, and none that somebody got into them does."""

from __future__ import annotations

import base64
import hashlib
import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from fake_gallery import run
from html_page import Page
from page_browser import browser

from pipeline.report.check import Refused, sheet
from pipeline.report.classes import CLASSES
from pipeline.report.environment import render
from pipeline.report.gallery import INDEX
from pipeline.report.policy import policy
from pipeline.report.run import read_run
from pipeline.tables.record import GALLERY, STUDY

__all__ = ["browser", "run"]

MARK = "document.documentElement.dataset.entered = 1"
ATTACKS = (
    f"<script>{MARK}</script>",
    f'<img src="data:image/png,none" onerror="{MARK}">',
    f"<svg onload='{MARK}'><script>{MARK}</script></svg>",
    f'<script src="data:text/javascript,{MARK}"></script>',
    '<script src="entered.js"></script>',
    f'<iframe srcdoc="<script>parent.{MARK}</script>"></iframe>',
    '<base href="https://example.org/"><form action="https://example.org/"><button id="send">send</button></form>',
    '<style>body{background:url("https://example.org/style.png")}</style><img src="https://example.org/picture.png">',
    '<link rel="stylesheet" href="https://example.org/style.css"><object data="entered.js"></object>',
)


def single_files() -> dict[str, str]:
    """Pages that stand alone."""
    return {
        "check.html": sheet("<name>", [], [Refused("a.png", "no picture")]),
        "studies.html": render("studies.html", run="a < b", studies=[]),
    }


def paths(run: Path) -> list[Path]:
    return [run / "report.html", *sorted((run / GALLERY).glob("*.html")), run / STUDY / INDEX]


def directives(text: str) -> dict[str, list[str]]:
    (meta,) = Page(text).all("meta", **{"http-equiv": "Content-Security-Policy"})
    return {words[0]: words[1:] for words in (part.split() for part in meta["content"].split(";"))}


def test_a_policy_admits_the_very_texts_of_a_page_and_no_others(run: Path) -> None:
    for text in [*(path.read_text(encoding="utf-8") for path in paths(run)), *single_files().values()]:
        found = directives(text)
        assert found["default-src"] == found["base-uri"] == found["form-action"] == ["'none'"]
        for tag, name in (("script", "script-src"), ("style", "style-src")):
            texts = re.findall(f"<{tag}>(.*?)</{tag}>", text, flags=re.DOTALL)
            digests = [hashlib.sha256(one.encode()).digest() for one in texts]
            admitted = [source for source in found.get(name, []) if source not in ("'self'", "file:")]
            assert admitted == [f"'sha256-{base64.b64encode(digest).decode()}'" for digest in digests]
        assert not [source for sources in found.values() for source in sources if "unsafe" in source]
        assert {"'self'", "file:", "http:", "https:", "*"}.isdisjoint(found.get("script-src", []))
        # It holds for what follows it alone.
        assert text.index("Content-Security-Policy") < min(text.index(f"<{tag}") for tag in ("link", "title"))
        for _, attrs, _ in Page(text).elements:
            assert "style" not in attrs and not any(name.startswith("on") for name in attrs)


def test_a_text_more_or_less_is_another_policy() -> None:
    assert policy(["a"], ["b"]) != policy(["a"], ["c"]) != policy(["b"], ["c"])
    assert "script-src" not in policy(["a"], []) and "'self'" not in policy(["a"], ["b"])


@pytest.fixture
def tab(browser: Any) -> Iterator[Any]:
    page = browser.new_page(viewport={"width": 1280, "height": 900})
    page.set_default_timeout(0)
    yield page
    page.close()


def complaints(tab: Any) -> list[str]:
    """What the page complains of from now on, and what it asks of others."""
    heard: list[str] = []
    tab.on("pageerror", lambda error: heard.append(str(error)))
    tab.on("console", lambda message: heard.append(message.text))
    tab.on("request", lambda request: None if request.url.startswith(("file:", "data:")) else heard.append(request.url))
    return heard


@pytest.mark.system
def test_pages_work_under_their_policies(tab: Any, run: Path, tmp_path: Path) -> None:
    heard = complaints(tab)
    for name, text in single_files().items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    first = run / GALLERY / read_run(run).constructed[0].page
    for path in [*paths(run), *(tmp_path / name for name in single_files())]:
        tab.goto(path.as_uri(), wait_until="load")
        assert tab.evaluate("getComputedStyle(document.querySelector('h1')).fontWeight") != "400", path  # styled
        images = "[...document.images].filter(one => one.complete && !one.naturalWidth).length"
        assert tab.evaluate(images) == 0, path
    tab.goto(first.as_uri(), wait_until="load")
    assert tab.is_visible(".player .bar")  # player.js has run
    tab.keyboard.press("Escape")  # gallery.js
    tab.wait_for_url(f"**/{INDEX}*")
    assert tab.is_visible(".controls")
    tab.goto((run / GALLERY / CLASSES).as_uri(), wait_until="load")
    assert tab.is_visible(".peek") and tab.evaluate(
        "getComputedStyle(document.querySelector('.matrix td a')).backgroundColor"
    ).startswith("rgb(")  # matrix.js, and the colours of the page's own style
    assert not heard


@pytest.mark.system
@pytest.mark.parametrize("attack", ATTACKS)
def test_what_somebody_gets_into_a_page_does_not_run(tab: Any, run: Path, tmp_path: Path, attack: str) -> None:
    entered = tmp_path / "run"
    shutil.copytree(run, entered)
    page = entered / GALLERY / INDEX
    (page.parent / "entered.js").write_text(MARK, encoding="utf-8")
    text = page.read_text(encoding="utf-8")
    page.write_text(text.replace("<main>", f"<main>{attack}", 1), encoding="utf-8")
    came: list[str] = []
    tab.on("requestfinished", lambda request: came.append(request.url))
    tab.route("https://example.org/**", lambda route: route.fulfill(body=""))  # as if there were a network
    tab.goto(page.as_uri(), wait_until="load")
    tab.evaluate("document.querySelector('#send')?.click()")
    assert tab.evaluate("document.documentElement.dataset.entered") is None
    assert tab.is_visible(".controls")  # what the page has of its own still runs
    assert not [address for address in came if "example.org" in address or "entered" in address]
    assert tab.url == page.as_uri() or tab.url.startswith(f"{page.as_uri()}#")


@pytest.mark.system
@pytest.mark.parametrize("attack", ATTACKS)
def test_without_the_policy_it_would_run(tab: Any, run: Path, tmp_path: Path, attack: str) -> None:
    """The attacks are real ones: the same page without its policy is entered."""
    text = (run / GALLERY / INDEX).read_text(encoding="utf-8")
    bare = re.sub(r'<meta http-equiv="Content-Security-Policy"[^>]*>', "", text)
    (tmp_path / "entered.js").write_text(MARK, encoding="utf-8")
    tab.route("https://example.org/**", lambda route: route.fulfill(body=""))
    (tmp_path / INDEX).write_text(bare.replace("<main>", f"<main>{attack}", 1), encoding="utf-8")
    if "example.org" not in attack:
        tab.goto((tmp_path / INDEX).as_uri(), wait_until="load")
        tab.wait_for_function("document.documentElement.dataset.entered")
        return
    with tab.expect_event("requestfinished", lambda request: "example.org" in request.url):
        tab.goto((tmp_path / INDEX).as_uri(), wait_until="load")
        tab.evaluate("document.querySelector('#send')?.click()")

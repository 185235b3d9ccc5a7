"""Pages of a running studio in a Chromium, and what a person does there, for tests."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from page_browser import chromium
from studio_process import StudioProcess, pictures, studio

from riot.transform.riot_file import from_json
from riot.transform.transform import Transform

FLAGS = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
"""Three dimensions are drawn without a graphics card."""
P, CHAIN, Q = (f"[data-view={view}] svg" for view in ("p", "chain", "q"))


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    yield from chromium(*FLAGS)


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[StudioProcess]:
    with studio(tmp_path_factory.mktemp("sessions")) as started:
        yield started


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    return pictures(tmp_path_factory.mktemp("pictures"))


@pytest.fixture
def open_page(browser: Any) -> Iterator[Callable[..., Any]]:
    """Opens pages that may complain of nothing, nor ask another host."""
    wrong: list[str] = []
    contexts = []

    def opened(address: str, **options: Any) -> Any:
        context = browser.new_context(**({"viewport": {"width": 1280, "height": 800}} | options))
        contexts.append(context)
        context.set_default_timeout(100_000)  # a machine may be busy
        page = context.new_page()
        page.on("pageerror", lambda error: wrong.append(str(error)))
        page.on("request", lambda request: wrong.append(request.url) if "//127.0.0.1:" not in request.url else None)
        page.goto(address)
        return page

    yield opened
    for context in contexts:
        context.close()
    assert not [text for text in wrong if not text.startswith(("data:", "blob:"))]


@pytest.fixture
def fresh(open_page: Callable[..., Any], served: StudioProcess) -> Any:
    """A page with a new piece of work."""
    page = open_page(served.address)
    begin(page)
    return page


def begin(page: Any) -> None:
    """Begin a new piece of work."""
    page.locator("#saved", has_text="Saved").wait_for()
    before = page.url
    page.click("#new")
    page.wait_for_url(lambda address: address != before)
    page.locator("#saved", has_text="Saved").wait_for()


def give_both(page: Any, files: tuple[Path, Path]) -> None:
    page.set_input_files("#file-p", files[0])
    page.set_input_files("#file-q", files[1])
    page.wait_for_url("**/*#look")
    planned(page)


def planned(page: Any) -> None:
    """Wait for how the exact transform moves; nothing on the page changes, nor shifts, by itself after that."""
    exact(page)
    page.locator("#certificate", has_text=re.compile("swings|needs")).wait_for()


def exact(page: Any) -> None:
    page.locator("#certificate", has_text="certified exact").wait_for()
    page.locator(".stage:not(.draft)").wait_for()


def step(page: Any, name: str) -> None:
    page.click(f"nav a[href='#{name}']")
    page.locator(f"body[data-step={name}]").wait_for()


def downloaded(page: Any) -> Transform:
    """What a person would have as a file now."""
    address = page.evaluate("`/api/sessions/${new URLSearchParams(location.search).get('session')}/download/riot`")
    return from_json(page.request.get(page.evaluate("location.origin") + address).text())


def on_outline(page: Any, view: str, share: float) -> tuple[float, float]:
    """A point of the screen on the input's outline, bent if it is."""
    return tuple(
        page.eval_on_selector(
            f"{view} :is(.ghost, .bent)",
            """(path, share) => {
                const at = path.getPointAtLength(share * path.getTotalLength()).matrixTransform(path.getScreenCTM());
                return [at.x, at.y];
            }""",
            share,
        )
    )


def shown(page: Any, view: str = CHAIN) -> list[str]:
    """Where the pieces lie."""
    return page.eval_on_selector_all(f"{view} [data-piece]", "all => all.map(one => one.getAttribute('transform'))")

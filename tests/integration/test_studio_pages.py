"""The studio in a browser under way: tabs, wrong files, an end by force, collections, screens, other eyes."""

from __future__ import annotations

import json
import re
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from studio_browser import (
    P,
    begin,
    browser,
    downloaded,
    exact,
    files,
    fresh,
    give_both,
    on_outline,
    open_page,
    planned,
    served,
    step,
)
from studio_process import HOUSE, StudioProcess, studio

from riot.transform.certificate import certify

__all__ = ["browser", "files", "fresh", "open_page", "served"]
STEPS = ("start", "look", "choose", "edit", "make")
SCREENS = {"desktop": (1280, 800), "tablet": (820, 1180), "phone": (390, 844)}

pytestmark = pytest.mark.system


def test_two_tabs_show_the_same(fresh: Any, files: tuple[Path, Path]) -> None:
    page = fresh
    other = page.context.new_page()
    other.goto(page.url)
    give_both(page, files)
    other.locator(".slot[data-side=q].filled").wait_for()
    step(other, "edit")
    planned(other)
    other.get_by_label("Keep", exact=True).check()
    other.mouse.click(*on_outline(other, P, 0.3))
    step(page, "edit")
    page.locator("#pins button").wait_for()
    page.locator("#undo").click()
    other.locator("#pins", has_text="Nothing is pinned").wait_for()


def test_pictures_given_before_the_page_is_ready_are_not_lost(
    open_page: Callable[..., Any], files: tuple[Path, Path], tmp_path: Path
) -> None:
    with studio(tmp_path) as served:
        page = open_page(served.address).context.new_page()
        held: list[Any] = []
        page.route("**/api/sessions", lambda route: held.append(route))
        page.goto(served.address)
        page.set_input_files("#file-p", files[0])
        page.set_input_files("#file-q", files[1])
        assert held
        page.route("**/api/sessions", lambda route: route.continue_())
        for route in held:
            route.continue_()
        page.wait_for_url("**/*#look")
        exact(page)


def test_files_that_are_no_shapes_are_told(fresh: Any, files: tuple[Path, Path], tmp_path: Path) -> None:
    page = fresh
    (tmp_path / "letter.png").write_text("dear studio")
    page.set_input_files("#file-p", tmp_path / "letter.png")
    page.locator(".slot[data-side=p] .bad", has_text="letter.png").wait_for()
    assert page.locator("nav a[href='#look']").get_attribute("aria-disabled") == "true"
    page.click("nav a[href='#look']", force=True)
    assert page.locator("#start").is_visible() and page.inner_text("#says") == "First give two pictures."
    drop = page.evaluate_handle(
        """text => {
            const data = new DataTransfer();
            data.items.add(new File([text], 'house.svg', {type: 'image/svg+xml'}));
            return data;
        }""",
        HOUSE,
    )
    page.dispatch_event("main", "drop", {"dataTransfer": drop})
    page.locator(".slot[data-side=p].filled", has_text="house").wait_for()
    assert page.inner_text(".slot[data-side=p] .bad") == ""


def test_nothing_is_lost_when_the_server_is_killed(
    open_page: Callable[..., Any], files: tuple[Path, Path], tmp_path: Path
) -> None:
    with studio(tmp_path) as first:
        page = open_page(first.address)
        give_both(page, files)
        step(page, "edit")
        page.get_by_label("Keep", exact=True).check()
        page.mouse.click(*on_outline(page, P, 0.3))
        page.locator("#pins button").wait_for()
        exact(page)
        first.end(signal.SIGKILL)
        page.locator("#status", has_text="does not answer").wait_for()
    with studio(tmp_path, "--port", first.port) as second:
        fresh_tab = page.context.new_page()
        fresh_tab.goto(second.address)
        page.locator("#status").wait_for(state="hidden")  # with the cookie of the new address the old tab goes on
        page.click("#undo")
        page.locator("#pins", has_text="Nothing is pinned").wait_for()
        page.keyboard.press("Control+Shift+z")
        page.locator("#pins button").wait_for()


def test_a_collection_has_a_wall_and_partners(open_page: Callable[..., Any], finished: Path, tmp_path: Path) -> None:
    with studio(tmp_path, "--in", str(finished / "outputs" / "folder")) as served:
        page = open_page(served.address)
        page.locator(".wall button").first.wait_for()
        page.fill(".controls [name=q]", "kind1")
        names = page.locator(".wall button").all_inner_texts()
        assert names and all("kind1" in name for name in names)
        page.locator(".wall button").first.focus()
        page.keyboard.press("Enter")
        page.locator("#partners .thumbnail").first.wait_for()
        page.locator("#partners button", has=page.locator(".thumbnail")).first.click()
        page.wait_for_url("**/*#look")
        exact(page)
        assert certify(downloaded(page)).passed


def test_a_wall_of_thousands_is_there_at_once(open_page: Callable[..., Any], finished: Path, tmp_path: Path) -> None:
    count = 3400
    listing = {"dataset": "many", "classes": ["a", "b"], "shapes": [[f"s{k}", k % 2, k / count] for k in range(count)]}
    asked = []

    def outlines(route: Any) -> None:
        asked.append(route.request.url)
        first = int(re.search(r"first=(\d+)", route.request.url)[1])
        route.fulfill(body=json.dumps({"first": first, "paths": ["m0 0l9 0 0 9z"] * min(200, count - first)}))

    with studio(tmp_path, "--in", str(finished / "outputs" / "folder")) as served:
        page = open_page(served.address)
        page.route("**/api/collection", lambda route: route.fulfill(body=json.dumps(listing)))
        page.route("**/api/collection/outlines?*", outlines)
        page.reload()
        page.locator(".controls .shown", has_text=f"{count} shapes").wait_for()
        page.locator(".wall path[d]").first.wait_for(state="attached")
        assert 0 < len(asked) <= 3  # of 17: the others when they are scrolled to
        page.select_option(".controls [name=class]", label="b")
        assert page.inner_text(".controls .shown") == f"{count // 2} of {count} shapes"


@pytest.fixture(scope="module")
def at_work(browser: Any, served: StudioProcess, files: tuple[Path, Path]) -> str:
    """The query of a piece of work that has a transform, a pin and a snapshot."""
    context = browser.new_context()
    context.set_default_timeout(100_000)
    page = context.new_page()
    page.goto(served.address)
    begin(page)
    give_both(page, files)
    step(page, "edit")
    page.get_by_label("Keep", exact=True).check()
    page.mouse.click(*on_outline(page, P, 0.3))
    page.locator("#pins button").wait_for()
    page.fill("#snapshot input", "kept")
    page.keyboard.press("Enter")
    page.locator("#snapshots li").wait_for()
    query = str(page.evaluate("location.search"))
    context.close()
    return query


def opened(open_page: Callable[..., Any], served: StudioProcess, query: str, **options: Any) -> Any:
    """A page of a piece of work."""
    page = open_page(served.address, **options)
    page.goto(page.url.split("?")[0].split("#")[0] + query + "#look")
    exact(page)
    return page


def see(page: Any, name: str) -> None:
    """Go to a step and wait until it shows what it is for."""
    step(page, name)
    if name == "choose":
        page.locator("#choose-note", has_text="best first").wait_for()
    if name == "make":
        page.locator(".labels li").first.wait_for()


@pytest.mark.parametrize("screen", SCREENS)
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_every_step_fits_its_screen(
    open_page: Callable[..., Any],
    served: StudioProcess,
    at_work: str,
    screen: str,
    scheme: str,
    request: pytest.FixtureRequest,
    tmp_path: Path,
) -> None:
    folder = Path(request.config.getoption("--pictures") or tmp_path)
    width, height = SCREENS[screen]
    size = {"width": width, "height": height}
    page = opened(open_page, served, at_work, viewport=size, color_scheme=scheme, reduced_motion="reduce")
    for name in STEPS:
        see(page, name)
        page.evaluate("scrollTo(0, 0)")
        page.screenshot(path=folder / f"{name}-{screen}-{scheme}.png")
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), name


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_nothing_stands_in_the_way_of_those_who_do_not_see_or_point(
    open_page: Callable[..., Any], served: StudioProcess, at_work: str, scheme: str
) -> None:
    axe = pytest.importorskip("axe_playwright_python.sync_playwright").Axe()
    page = opened(open_page, served, at_work, color_scheme=scheme)
    for name in STEPS:
        see(page, name)
        answer = axe.run(page)
        assert answer.violations_count == 0, answer.generate_report()

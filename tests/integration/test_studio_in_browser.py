"""The studio in a browser, as a person uses it: from two pictures to parts, and what comes between."""

from __future__ import annotations

import json
import re
import shutil
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from studio_process import HOUSE, StudioProcess, pictures, studio

from riot.transform.certificate import certify
from riot.transform.riot_file import from_json
from riot.transform.transform import Transform

pytestmark = pytest.mark.system
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
"""Three dimensions are drawn without a graphics card."""
P, CHAIN, Q = (f"[data-view={view}] svg" for view in ("p", "chain", "q"))


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed (extra dev)")
    if CHROMIUM is None:
        pytest.skip("there is no Chromium on this machine")
    with api.sync_playwright() as started:
        launched = started.chromium.launch(executable_path=CHROMIUM, args=FLAGS, timeout=0)
        yield launched
        launched.close()


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
    with page.expect_navigation():
        page.click("#new")
    page.locator("#saved", has_text="Saved").wait_for()
    return page


def give_both(page: Any, files: tuple[Path, Path]) -> None:
    page.set_input_files("#file-p", files[0])
    page.set_input_files("#file-q", files[1])
    page.wait_for_url("**/*#look")
    exact(page)


def exact(page: Any) -> None:
    page.locator("#certificate", has_text="certified exact").wait_for()
    page.locator(".stage:not(.draft)").wait_for()


def step(page: Any, name: str) -> None:
    page.click(f"nav a[href='#{name}']")
    page.locator(f"body[data-step={name}]").wait_for()


def downloaded(page: Any) -> Transform:
    """What a person would have as a file now."""
    step(page, "make")
    href = page.locator("#files a", has_text=".riot").get_attribute("href")
    return from_json(page.request.get(f"{page.url.split('/?')[0].split('/#')[0]}{href}").text())


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


def test_from_two_pictures_to_parts(fresh: Any, files: tuple[Path, Path]) -> None:
    page = fresh
    give_both(page, files)
    assert "alike" in page.inner_text("[data-view=p] figcaption")
    count = page.locator(f"{CHAIN} [data-piece]").count()
    assert count == page.locator(f"{P} [data-piece]").count() >= 3

    step(page, "choose")
    page.locator("#choose-note", has_text="best first").wait_for()
    other = page.locator("#alternatives button[aria-pressed=false]").first
    words = other.locator("small").inner_text()
    other.click()
    page.locator("#alternatives button[aria-pressed=true]", has_text=words).wait_for()
    exact(page)

    step(page, "edit")
    page.get_by_label("Keep", exact=True).check()
    page.mouse.click(*on_outline(page, P, 0.3))
    page.locator("#pins", has_text="kept point on house").wait_for()
    exact(page)
    transform = downloaded(page)
    assert certify(transform).passed and transform.plan is not None

    page.click("#settings .primary")
    page.locator("#findings", has_text=re.compile("holds|does not hold")).wait_for()
    page.locator(".labels li").nth(len(transform) - 1).wait_for()
    assert page.locator("#parts li", has_text="piece").count() == len(transform)
    answer = page.request.get(page.locator("#files a", has_text="zip").evaluate("link => link.href"))
    assert answer.ok and answer.body()[:2] == b"PK"


def test_pieces_swing_by_play_slider_and_drag(fresh: Any, files: tuple[Path, Path]) -> None:
    page = fresh
    give_both(page, files)
    play, slider = page.locator("#play"), page.locator("#slider")
    assert play.inner_text() == "Pause"
    play.click()
    slider.fill("0")
    assert shown(page) == shown(page, P)
    slider.fill("1")
    assert shown(page) == shown(page, Q)

    def middle(time: str) -> tuple[float, float]:
        slider.fill(time)
        box = page.locator(f"{CHAIN} [data-piece] .piece").last.bounding_box()
        return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2

    ahead, here = middle("0.6"), middle("0.4")
    page.mouse.move(*here)
    page.mouse.down()
    page.mouse.move(*ahead, steps=20)
    page.mouse.up()
    assert 0.5 < float(slider.input_value()) < 0.7
    slider.focus()
    before = shown(page)
    page.keyboard.press("ArrowRight")
    assert shown(page) != before


def test_a_point_is_pulled_answered_while_it_moves_and_undone_by_keys(fresh: Any, files: tuple[Path, Path]) -> None:
    page = fresh
    give_both(page, files)
    before = downloaded(page)
    step(page, "edit")
    x, y = on_outline(page, P, 0.1)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 14, y - 10, steps=8)
    page.locator(".stage.draft, #status.problem").first.wait_for()
    page.mouse.up()
    page.locator("#undo[title$=pull], #status.problem").first.wait_for()
    if not page.locator("#status.problem").is_visible():
        exact(page)
        pulled = downloaded(page)
        assert certify(pulled).passed and not np.array_equal(pulled.outline_p(), before.outline_p())
        step(page, "edit")
        page.locator("main").focus()
        page.keyboard.press("Control+z")
        page.locator("#redo[title$=pull]").wait_for()
    assert np.array_equal(downloaded(page).outline_p(), before.outline_p())


def test_keys_edit_as_the_pointer_does(fresh: Any, files: tuple[Path, Path]) -> None:
    page = fresh
    give_both(page, files)
    step(page, "edit")
    page.get_by_label("Keep", exact=True).focus()
    page.keyboard.press("Space")
    page.locator(P).focus()
    for key in ("ArrowRight", "Shift+ArrowRight", "Enter", "Enter"):
        page.keyboard.press(key)
    page.locator("#pins button, #status.problem").first.wait_for()
    page.get_by_label("Draw", exact=True).check()
    page.locator(P).focus()
    for key in ("ArrowRight", "Enter", "ArrowUp", "Escape"):
        page.keyboard.press(key)
    assert page.locator(".mark-line").count() == 0


def test_what_cannot_be_is_said_where_it_is(fresh: Any, files: tuple[Path, Path]) -> None:
    page = fresh
    give_both(page, files)
    step(page, "edit")
    page.get_by_label("Draw", exact=True).check()
    begin, end = on_outline(page, P, 0.0), on_outline(page, P, 0.5)
    page.mouse.move(*begin)
    page.mouse.down()
    page.mouse.move(*end, steps=8)
    page.mouse.up()
    problem = page.locator("#status.problem")
    problem.wait_for()
    assert problem.inner_text() == page.inner_text("#says").strip()
    assert page.locator("#undo").get_attribute("title") != "Undo: draw"


def test_snapshots_stand_side_by_side_and_are_gone_back_to(fresh: Any, files: tuple[Path, Path]) -> None:
    page = fresh
    give_both(page, files)
    first = downloaded(page)
    step(page, "edit")
    page.fill("#snapshot input", "as it came")
    page.keyboard.press("Enter")
    page.locator("#snapshots li", has_text="as it came").wait_for()
    step(page, "choose")
    page.get_by_label("do not bend").check()
    page.locator("#undo[title$=weight]").wait_for()
    exact(page)
    step(page, "edit")
    page.click("#compare")
    page.locator("dialog .cards li").nth(1).wait_for()
    page.locator("dialog button", has_text="as it came").click()
    page.locator("#undo[title*=restore]").wait_for()
    exact(page)
    assert np.array_equal(downloaded(page).outline_p(), first.outline_p())


def test_two_tabs_show_the_same(fresh: Any, files: tuple[Path, Path]) -> None:
    page = fresh
    other = page.context.new_page()
    other.goto(page.url)
    give_both(page, files)
    other.locator(".slot[data-side=q].filled").wait_for()
    step(other, "edit")
    exact(other)
    other.get_by_label("Keep", exact=True).check()
    other.mouse.click(*on_outline(other, P, 0.3))
    step(page, "edit")
    page.locator("#pins button").wait_for()
    page.locator("#undo").click()
    other.locator("#pins", has_text="Nothing is pinned").wait_for()


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

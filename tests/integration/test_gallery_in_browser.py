"""The gallery of an invented run in a browser: filters, sorting, keys, swings, without script too."""

import math
import shutil

import pytest
from fake_gallery import MANY, many, rows, run
from page_browser import browser

from pipeline.report.classes import CLASSES
from pipeline.report.gallery import INDEX, ORDERS
from pipeline.report.run import read_run
from pipeline.tables.record import GALLERY

__all__ = ["browser", "many", "rows", "run"]

READY = "domcontentloaded"
"""When the scripts have run; pictures may still come."""


def new_page(browser):
    """A page as wide as a phone, without limits of time: machines may be busy, and the suite has a limit of its own."""
    page = browser.new_page(viewport={"width": 390, "height": 844})
    page.set_default_timeout(0)
    return page


@pytest.fixture
def tab(browser, many):
    page = new_page(browser)
    wrong = []
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.on("request", lambda request: wrong.append(request.url) if not request.url.startswith("file:") else None)
    page.goto((many / INDEX).as_uri(), wait_until=READY)
    yield page
    page.close()
    assert not wrong


def visible(tab):
    """Ranks of what is shown, in order."""
    positions = tab.eval_on_selector_all(
        ".wall li", "all => all.filter(one => !one.hidden).map(one => one.dataset.v.split(' ')[0])"
    )
    return [int(position) for position in positions]


def chosen(rows, passes):
    return [row.rank for row in rows if passes(row)]


def test_filters_show_what_passes_all_of_them(tab, rows):
    assert visible(tab) == chosen(rows, lambda row: True)
    assert tab.evaluate("document.documentElement.scrollWidth <= innerWidth")  # nothing sticks out on a phone
    tab.select_option("[name=class]", label="class & 3")
    assert visible(tab) == chosen(rows, lambda row: "class & 3" in row.classes)
    tab.check("[name=flat]")
    tab.select_option("[name=n]", "5")
    tab.fill("[name=iou]", "0.9")
    passing = chosen(
        rows, lambda row: "class & 3" in row.classes and row.swings_flat and row.n == 5 and round(row.iou, 5) >= 0.9
    )
    assert visible(tab) == passing and 0 < len(passing) < MANY
    assert tab.inner_text(".shown") == f"{len(passing)} of {MANY} transforms"
    tab.reload(wait_until=READY)  # what was chosen is in the address
    assert visible(tab) == passing
    tab.click("[type=reset]")
    tab.check("[name=puzzle]")
    assert visible(tab) == [2, 9]
    tab.fill("[name=q]", "<SHAPE> 8 KIND")
    assert visible(tab) == [9]


def test_sorts_by_any_score_the_best_first_and_what_has_none_last(tab, rows):
    def key(row, value, sign):
        shown = float(f"{value(row):.5g}")
        return (math.isnan(shown), 0.0 if math.isnan(shown) else sign * shown, row.rank)

    for turn, order in enumerate(("crs", "qcrs", "n", "bending")):
        value, sign = ORDERS[order].value, -1 if ORDERS[order].greatest_first else 1
        tab.select_option("[name=sort]", order)
        for back in (turn % 2 == 1, turn % 2 == 0):  # as the order before left it, then the other way
            tab.set_checked("[name=reverse]", back)
            ordered = sorted(rows, key=lambda row: key(row, value, -sign if back else sign))
            assert visible(tab) == [row.rank for row in ordered], (order, back)


def test_keys_lead_through_the_gallery(tab, rows, many):
    focused = "document.activeElement.parentElement.dataset.v?.split(' ')[0]"
    tab.keyboard.press("/")
    tab.keyboard.type("2 class")
    shown = visible(tab)
    assert shown == chosen(rows, lambda row: "2" in f"{row.name_p} {row.name_q} {row.class_p} {row.class_q}")
    tab.keyboard.press("Enter")
    assert tab.evaluate(focused) == str(shown[0])
    for press, number in (
        ("ArrowRight", 1),
        ("ArrowDown", 3),
        ("ArrowLeft", 2),
        ("ArrowUp", 0),
        ("End", -1),
        ("Home", 0),
    ):
        tab.keyboard.press(press)  # two in a row at this width
        assert tab.evaluate(focused) == str(shown[number]), press
    opened = rows[shown[0] - 1].page
    shutil.copy(many / rows[0].page, many / opened)
    tab.keyboard.press("Enter")
    tab.wait_for_url(f"**/{opened}", wait_until=READY)
    tab.keyboard.press("Escape")
    tab.wait_for_url(f"**/{INDEX}*", wait_until=READY)


def test_pictures_out_of_sight_are_not_loaded(tab):
    tab.wait_for_function("document.images[0].complete")
    loaded = tab.evaluate("[...document.images].filter(one => one.complete && one.naturalWidth).length")
    assert 0 < loaded < MANY / 4


def test_without_script_there_is_a_list_and_no_form(browser, many):
    page = browser.new_page(java_script_enabled=False)
    page.set_default_timeout(0)
    page.goto((many / INDEX).as_uri(), wait_until=READY)
    assert page.locator(".wall li:visible").count() == MANY
    assert not page.locator(".controls").is_visible()
    page.close()


@pytest.fixture
def transform_tab(browser, run):
    page = browser.new_page(viewport={"width": 1280, "height": 900})
    page.set_default_timeout(0)
    wrong = []
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.on("console", lambda message: wrong.append(message.text))
    page.goto((run / GALLERY / read_run(run).constructed[0].page).as_uri(), wait_until="load")
    yield page
    page.close()
    assert not wrong


def way(tab):
    return float(tab.input_value(".bar input"))


@pytest.mark.system
def test_a_swing_plays_slides_and_is_dragged(transform_tab):
    tab, button = transform_tab, transform_tab.locator(".bar button")
    assert button.inner_text() == "Pause"
    button.click()
    assert button.inner_text() == "Play"
    piece = tab.locator(".r-move > g use").last

    def slide(to):
        tab.eval_on_selector(
            ".bar input", "(bar, to) => { bar.value = to; bar.dispatchEvent(new Event('input')); }", to
        )
        return piece.bounding_box()

    ends = slide(0), slide(1)
    assert max(abs(ends[0][name] - ends[1][name]) for name in ("x", "y")) > 10
    after = slide(0.6)
    slide(0.4)
    x, y = (after[name] + after[size] / 2 for name, size in (("x", "width"), ("y", "height")))
    box = piece.bounding_box()
    tab.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    tab.mouse.down()
    tab.mouse.move(x, y, steps=20)
    tab.mouse.up()
    assert 0.5 < way(tab) < 0.7  # where the slider had led it


@pytest.mark.system
def test_a_picture_swings_while_the_pointer_or_the_focus_is_on_it(browser, run):
    page = browser.new_page(viewport={"width": 1280, "height": 900})
    page.set_default_timeout(0)
    page.goto((run / GALLERY / INDEX).as_uri(), wait_until="load")
    still, swinging = (read_run(run).constructed[0].thumb, read_run(run).constructed[0].swing)
    picture, shown = page.locator(".wall img").first, lambda: picture.get_attribute("src")
    assert shown() == still
    page.locator(".wall a").first.hover()
    assert shown() == swinging
    page.mouse.move(1, 1)
    assert shown() == still
    page.locator(".wall a").first.focus()
    assert shown() == swinging
    page.locator(".wall a").nth(1).focus()
    assert shown() == still
    page.close()


@pytest.mark.system
def test_pages_are_calm_for_those_who_ask_for_it(browser, run):
    page = browser.new_page(reduced_motion="reduce")
    page.set_default_timeout(0)
    page.goto((run / "report.html").as_uri(), wait_until="load")
    sources = page.eval_on_selector_all(".first img", "all => all.map(one => one.currentSrc)")
    assert len(sources) == 4 and not [source for source in sources if ".swing." in source]
    assert page.inner_text(".pause") == "Play"
    page.click(".pause")
    page.wait_for_function(
        "[...document.querySelectorAll('.first img')].every(one => one.currentSrc.includes('.swing.'))"
    )
    page.close()


@pytest.mark.system
def test_arrows_lead_through_the_matrix_and_no_page_complains(browser, run):
    page = browser.new_page(viewport={"width": 390, "height": 844})
    page.set_default_timeout(0)
    wrong = []
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.on("console", lambda message: wrong.append(message.text))
    for path in (run / "report.html", run / GALLERY / INDEX, run / GALLERY / CLASSES):
        page.goto(path.as_uri(), wait_until="load")
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), path
    cells = page.locator(".matrix td a")
    assert cells.count() == 2 and page.locator(".matrix td a[tabindex='0']").count() == 1
    cells.first.focus()
    assert cells.first.get_attribute("aria-label") == page.inner_text(".peek")
    page.keyboard.press("ArrowRight")  # there is none
    assert page.evaluate("document.activeElement.ariaLabel") == cells.first.get_attribute("aria-label")
    page.close()
    assert not wrong

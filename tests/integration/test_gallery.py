"""The gallery of an invented run: a plain list without script; with it, a thousand transforms filtered and sorted."""

import io
import math
import re
import shutil
import xml.etree.ElementTree as ET
from dataclasses import replace

import fake_run
import numpy as np
import pytest
from html_page import Page
from PIL import Image

from pipeline.report import gallery, write_report
from pipeline.report.classes import CLASSES, classes_page
from pipeline.report.first import FIRST, first_transforms
from pipeline.report.gallery import INDEX, ORDERS, SCRIPTS, STYLE, index
from pipeline.report.page import SHOWN_TRANSFORMS
from pipeline.report.pictures import PREVIEW, preview, swing, thumb
from pipeline.report.run import read_run
from pipeline.study.contents import write_contents
from pipeline.tables.record import GALLERY
from riot.transform.history import History, HistoryStep

MANY = 1000
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("outputs") / "fake"
    folder.mkdir()
    transforms = fake_run.transforms()
    history = History(
        "riot make", ("ab" * 32, "cd" * 32), (HistoryStep("trunks", {"spacing": 15.0}, "ef" * 32),), {"numpy": "2"}
    )
    transforms[0] = replace(transforms[0], history=history)
    names = {"name_i": "a", "name_j": "b", "class_i": "", "class_j": ""}
    puzzle = names | {
        "rank": 1,
        "status": "certified",
        "folder": "print/0001",
        "size": 120.0,
        "parts": 9,
        "message": "",
    }
    refused = names | {"rank": 2, "status": "refused", "folder": "", "message": "the neck of piece 2 is <thin>"}
    fake_run.write_fake_run(folder, exact=transforms, fabrications=[puzzle, refused])
    (folder / "print" / "0001").mkdir(parents=True)
    (folder / "print" / "0001" / "plate.3mf").write_bytes(b"solid")
    write_contents(folder)
    write_report(folder)
    return folder


@pytest.fixture(scope="module")
def rows(run):
    """A thousand rows of transforms that are not there."""
    rng, known = np.random.default_rng(5), read_run(run).constructed
    return [
        replace(
            known[k % len(known)],
            rank=k + 1,
            name_p=f"<shape> {k}",
            class_p=f"class & {k % 7}",
            class_q=f"kind {k % 3}",
            file=f"transforms/{k + 1:04d}.riot",
            n=3 + k % 4,
            iou=1.0 - 0.0002 * k,
            crs=float(rng.random()),
            qcrs=math.nan if k % 100 == 0 else float(rng.random()),
            swings_flat=k % 5 != 0,
        )
        for k in range(MANY)
    ]


@pytest.fixture(scope="module")
def many(rows, run, tmp_path_factory):
    """The gallery of those rows, as files."""
    folder = tmp_path_factory.mktemp("many")
    (folder / INDEX).write_text(index("many", rows, frozenset({2, 9})), encoding="utf-8")
    for name, text in gallery.files().items():
        (folder / name).write_text(text, encoding="utf-8")
    pictures = sorted((run / GALLERY).glob("*.svg"))
    for k, row in enumerate(rows):
        shutil.copy(pictures[k % len(pictures)], folder / row.thumb)
    single = (run / GALLERY / read_run(run).constructed[0].page).read_text(encoding="utf-8")
    (folder / rows[0].page).write_text(single, encoding="utf-8")
    return folder


def test_every_link_and_picture_is_there(run):
    pages = sorted((run / GALLERY).glob("*.html"))
    assert len(pages) == 2 + len(read_run(run).constructed)
    for page in [*pages, run / "report.html"]:
        parsed = Page(page.read_text(encoding="utf-8"))
        assert not parsed.stack
        ids = [attrs["id"] for _, attrs, _ in parsed.elements if "id" in attrs]
        assert len(ids) == len(set(ids))
        for tag, attrs, _ in parsed.elements:
            assert not any(name.startswith("on") for name in attrs)
            for name in {"href", "src", "srcset"} & set(attrs):
                address = attrs[name]
                address, _, place = address.partition("#")
                if not address:
                    assert place in ids
                elif not address.startswith("data:image/"):
                    assert (
                        tag in {"a", "link", "img", "script", "source"} and (page.parent / address).resolve().exists()
                    ), address


def test_is_a_plain_list_without_script(run):
    parsed = Page((run / GALLERY / INDEX).read_text(encoding="utf-8"))
    rows = read_run(run).constructed
    (form,) = parsed.all("form")
    assert "hidden" in form  # until the script shows it
    names = [row.page for row in rows]
    assert [attrs["href"] for attrs in parsed.all("a") if attrs["href"].startswith("0")] == names
    pictures = parsed.all("img")
    assert [attrs["src"] for attrs in pictures] == [row.thumb for row in rows]
    assert all(attrs["loading"] == "lazy" and attrs["width"] for attrs in pictures)
    shown = "".join(parsed.text)
    for row in rows:
        assert f"{row.name_p} ⇄ {row.name_q}".translate({1: "�", 127: "�"}) in shown and f"IoU {row.iou:.2f}" in shown


def test_a_page_tells_all_of_its_transform(run):
    rows = read_run(run).constructed
    texts = [(run / GALLERY / row.page).read_text(encoding="utf-8") for row in rows]
    first, second, last = Page(texts[0]), Page(texts[1]), Page(texts[-1])
    rels = [[attrs.get("rel") for attrs in page.all("a") if "rel" in attrs] for page in (first, second, last)]
    assert rels == [["up", "next"], ["prev", "up", "next"], ["prev", "up"]]
    assert sum("picture P: sha256 " + "ab" * 32 in text for text in texts) == 1
    assert {"href": "../print/0001/plate.3mf", "download": None} in first.all("a")
    assert "the neck of piece 2 is <thin>" in "".join(second.text)
    for row, text in zip(rows, texts, strict=True):
        shown = "".join(Page(text).text)
        assert f"{row.crs:.3f}" in shown and "open hinge" in shown and {"href": f"../{row.file}"} in Page(text).all("a")
        about = {attrs.get("property", attrs.get("name")): attrs["content"] for attrs in Page(text).all("meta")[1:]}
        assert about["og:image"] == row.preview and f"the same {row.n} hinged pieces" in about["description"]
        assert f"riot show {row.file} -o" in shown
        assert text.count("<animateTransform") >= 2 * row.n


def test_is_the_same_every_time_and_everywhere(run, tmp_path):
    elsewhere = tmp_path / "another place" / run.name
    shutil.copytree(run, elsewhere)
    write_report(elsewhere)
    files = {file.name: file.read_bytes() for file in (run / GALLERY).iterdir()}
    assert {file.name: file.read_bytes() for file in (elsewhere / GALLERY).iterdir()} == files
    assert not [path for path in elsewhere.iterdir() if path.name.startswith(".")]


def test_an_older_gallery_is_replaced_and_lost_transforms_are_not_in_it(run, tmp_path):
    folder = tmp_path / "run"
    shutil.copytree(run, folder)
    rows = read_run(folder).constructed
    (folder / rows[1].file).unlink()
    write_report(folder)
    names = {file.name for file in (folder / GALLERY).iterdir()}
    kept = [row for row in rows if row.rank != 2]
    pictures = [name for row in kept for name in (row.page, row.thumb, row.swing, row.preview)]
    assert names == {INDEX, CLASSES, STYLE, *SCRIPTS, *pictures}
    page = Page((folder / GALLERY / rows[0].page).read_text(encoding="utf-8"))
    assert [link["href"] for link in page.all("a") if link.get("rel") == "next"] == [rows[2].page]


def test_a_small_picture_shows_both_shapes_at_one_scale_in_light_and_dark():
    for transform in fake_run.transforms():
        text = thumb(transform)
        root = ET.fromstring(text)
        space = "{http://www.w3.org/2000/svg}"
        n = len(transform)
        assert len(root.findall(f"{space}use")) == 2 * n and len(root.findall(f".//{space}g")) == n
        left, top, width, height = map(float, root.get("viewBox").split())
        assert width == 2 * height and left == -width / 2 and top == -height / 2
        assert "scale" not in text and "prefers-color-scheme:dark" in text
        assert len(text) < 8000


def test_the_report_shows_the_best_and_leads_to_the_others(run, tmp_path, monkeypatch):
    assert SHOWN_TRANSFORMS == 100
    monkeypatch.setattr("pipeline.report.page.SHOWN_TRANSFORMS", 2)
    folder = tmp_path / "run"
    shutil.copytree(run, folder)
    page = Page(write_report(folder).read_text(encoding="utf-8"))
    rows = read_run(folder).constructed
    on_wall = [attrs["src"] for tag, attrs, stack in page.elements if tag == "img" and "picture" not in stack]
    assert on_wall == [f"{GALLERY}/{row.thumb}" for row in rows[:2]]
    links = [attrs["href"] for attrs in page.all("a")]
    assert f"{GALLERY}/{rows[2].page}" in links and f"{GALLERY}/{INDEX}" in links


def test_the_first_are_of_different_things_and_swing(rows):
    first = first_transforms(rows)
    assert len(first) == FIRST and first[0].rank == rows[1].rank  # the best one lifts, the next swings flat
    things = [{row.class_p, row.class_q} for row in first[:3]]
    assert not things[0] & things[1] and not things[0] & things[2] and not things[1] & things[2]
    rated = [replace(row, surprise=0.01 * row.rank, margin=0.5) for row in rows[:50]]
    assert first_transforms(rated)[0].rank == 50 - (rated[-1].swings_flat is False)
    paper = [replace(row, status="approximate") for row in rows]
    assert first_transforms(paper) == [] == first_transforms([])
    alike = [replace(row, class_p="", class_q="", name_p="a", name_q="b") for row in rows[:9]]
    assert len(first_transforms(alike)) == FIRST  # rather the same things again than an empty place


def test_pictures_of_a_transform():
    transform = fake_run.transforms()[1]
    moving = swing(transform)
    root = ET.fromstring(moving)
    assert moving.count("<animateTransform") == 2 * len(transform) and root.get("viewBox")
    defined = set(re.findall(r"(--[\w-]+):#", moving))
    assert set(re.findall(r"var\((--[\w-]+)\)", moving)) <= defined
    with Image.open(io.BytesIO(preview(transform))) as picture:
        assert picture.size == PREVIEW and picture.convert("RGB").getcolors(100_000)[0][0] < 0.9 * math.prod(PREVIEW)


def test_a_thousand_transforms_make_a_small_page(rows):
    text = index("many", rows)
    assert len(text.encode()) < 520 * MANY
    page = Page(text)
    assert len(page.all("li")) == MANY and not page.all("svg")
    assert all(len(attrs["data-v"].split()) == len(ORDERS) for attrs in page.all("li"))
    assert len(page.elements) < 7 * MANY


def test_a_gallery_sorts_by_what_the_run_has(rows):
    def offered(rows):
        return [attrs["value"] for attrs in Page(index("some", rows)).all("option") if "data-sign" in attrs]

    assert not {"surprise", "strain", "recognised"} & set(offered(rows))
    rich = [replace(row, surprise=0.5, margin=0.25, rms_strain=0.01) for row in rows]
    assert "bent 1.0" in index("some", rich[:1]) and "bent" not in index("some", rows[:1])
    assert offered(rich)[:5] == ["rank", "recognised", "iou", "strain", "surprise"]


def test_every_class_has_a_place_and_the_best_is_in_it(run, rows):
    reported = read_run(run)
    page = Page((run / GALLERY / CLASSES).read_text(encoding="utf-8"))
    assert [kind.name for kind in reported.classes] == ["animal", "c0", "c1", "thing <2>", "Zoo"]
    places = [attrs.get("class") for tag, attrs, stack in page.elements if tag == "li" and stack[-1] == "ol"]
    assert places == [None, "none", "none", None, "none"]  # "animal" and "thing <2>" have transforms
    shown = "".join(page.text)
    assert "2 of 5 classes have a transform" in shown and "None of its pairs was selected" in shown
    assert [attrs["src"] for attrs in page.all("img")] == [reported.constructed[0].thumb, reported.constructed[1].thumb]


def test_the_matrix_leads_to_the_best_of_every_two_classes(run, rows):
    reported = read_run(run)
    kind = reported.classes[0]
    kinds = tuple(
        replace(kind, name=f"{word} {k}") for word, count in (("class &", 7), ("kind", 3)) for k in range(count)
    )
    page = Page(classes_page(replace(reported, classes=kinds), rows))
    best = {}
    for row in rows:
        pair = frozenset(row.classes)
        best[pair] = max(best.get(pair, row), row, key=lambda row: row.iou)
    cells = [attrs for tag, attrs, stack in page.elements if tag == "a" and stack[-1] == "td"]
    assert sorted(attrs["href"] for attrs in cells) == sorted(2 * [row.page for row in best.values()])
    assert all(attrs["aria-label"] and attrs["class"].startswith("tone") for attrs in cells)
    widths = [int(attrs.get("colspan", 1)) for tag, attrs, stack in page.elements if tag == "td" and "tbody" in stack]
    assert sum(widths) == len(kinds) ** 2
    used = {attrs["class"] for attrs in cells}
    assert used <= {attrs["class"] for attrs in page.all("i") if "class" in attrs}  # the legend tells what they mean


def test_a_run_without_classes_has_no_page_of_classes(run, tmp_path):
    folder = tmp_path / "run"
    shutil.copytree(run, folder)
    fake_run.write_table(folder, "shapes", [{"shape": k, "name": f"s{k}", "class": ""} for k in range(40)])
    text = write_report(folder).read_text(encoding="utf-8")
    assert not (folder / GALLERY / CLASSES).exists() and CLASSES not in text
    assert CLASSES not in (folder / GALLERY / INDEX).read_text(encoding="utf-8")


def test_an_empty_gallery_says_so():
    page = Page(index("none", []))
    assert "No transform was constructed." in "".join(page.text) and not page.all("li")


@pytest.fixture(scope="module")
def browser():
    api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed (extra dev)")
    if CHROMIUM is None:
        pytest.skip("there is no Chromium on this machine")
    with api.sync_playwright() as started:
        launched = started.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"], timeout=0)
        yield launched
        launched.close()


READY = "domcontentloaded"
"""When the script has run; pictures may still come."""


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
    page = new_page(browser)
    page.route("**/*.js", lambda route: route.abort())
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

"""The gallery of an invented run, without a browser: pages, links, pictures, order."""

import io
import json
import math
import re
import shutil
import xml.etree.ElementTree as ET
from dataclasses import replace

import fake_run
from fake_gallery import MANY, rows, run
from html_page import Page
from PIL import Image

from pipeline.report import write_report
from pipeline.report.classes import CLASSES, classes_page
from pipeline.report.first import FIRST, first_transforms
from pipeline.report.gallery import INDEX, ORDERS, STYLE, index
from pipeline.report.page import SHOWN_TRANSFORMS
from pipeline.report.pictures import PREVIEW, preview, swing, thumb
from pipeline.report.run import read_run
from pipeline.tables.record import GALLERY, RECORD

__all__ = ["rows", "run"]


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
                    assert tag in {"a", "link", "img", "source"} and (page.parent / address).resolve().exists(), address


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


def test_link_previews_have_the_address_where_a_run_is_published(run, tmp_path):
    published = tmp_path / run.name
    shutil.copytree(run, published)
    facts = json.loads((published / RECORD).read_text(encoding="utf-8"))
    facts.setdefault("configuration", {})["address"] = "https://example.org/mpeg7/"
    (published / RECORD).write_text(json.dumps(facts), encoding="utf-8")
    report, row = write_report(published), read_run(published).constructed[0]
    for page, picture in ((report, None), (published / GALLERY / row.page, row.preview)):
        metas = Page(page.read_text(encoding="utf-8")).all("meta")
        (address,) = (attrs["content"] for attrs in metas if attrs.get("property") == "og:image")
        assert address.startswith(f"https://example.org/mpeg7/{GALLERY}/")
        assert (published / address.removeprefix("https://example.org/mpeg7/")).is_file()
        assert picture is None or address.endswith(f"/{picture}")


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
    assert names == {INDEX, CLASSES, STYLE, *pictures}
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
    named = [replace(row, class_p="device3", class_q="device7") for row in rated[:20]]
    assert first_transforms([replace(named[0], class_p="cup", class_q="key"), *named[1:]])[0].rank == named[0].rank


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

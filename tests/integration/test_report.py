"""The report of an invented run: complete, self-contained, escaped, and the same every time."""

import json
import re
import shutil
import xml.etree.ElementTree as ET

import fake_run
import numpy as np
import pytest
from html_page import Page

from pipeline.report import write_report
from pipeline.report.formats import residual
from pipeline.report.histogram import CELLS, distribution
from pipeline.report.run import ReportError, read_run
from pipeline.stages.paint import pack_images
from pipeline.stages.paper import same_trunks
from pipeline.store.artifact import Artifact, encode
from pipeline.study.contents import write_contents
from pipeline.tables import schemas as tables
from pipeline.tables.record import GALLERY
from riot.construction.laplacian import construct_laplacian
from riot.draw.palette import hue
from riot.draw.texture.paint import pattern_texture
from riot.draw.texture.sample import piece_images
from riot.parameters import ConstructParameters
from riot.transform.deformation import measure_deformation


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("outputs") / "fake"
    folder.mkdir()
    transforms = fake_run.write_fake_run(folder)
    write_contents(folder)
    return folder, transforms, write_report(folder).read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def parsed(run):
    return Page(run[2])


def cards(folder):
    """The cards of all transforms, on their pages."""
    texts = [(folder / GALLERY / row.page).read_text(encoding="utf-8") for row in read_run(folder).constructed]
    return [re.search(r'<article class="card".*?</article>', text, flags=re.DOTALL).group(0) for text in texts]


def test_is_well_formed(parsed):
    assert not parsed.stack
    ids = [attrs["id"] for _, attrs, _ in parsed.elements if "id" in attrs]
    assert len(ids) == len(set(ids))


def test_needs_nothing_but_itself_and_the_gallery(parsed, run):
    assert {tag for tag, _, _ in parsed.elements}.isdisjoint({"iframe", "object", "embed", "image"})
    ids = {f"#{attrs['id']}" for _, attrs, _ in parsed.elements if "id" in attrs}
    for tag, attrs, _ in parsed.elements:
        assert not any(name.startswith("on") for name in attrs), attrs
        for name in ("href", "src", "srcset", "xlink:href"):
            if name not in attrs or attrs[name] in ids:
                continue
            if tag == "link":
                assert attrs[name].startswith("data:image/svg+xml,")
            else:
                assert tag in {"a", "img", "source"} and (run[0] / attrs[name].partition("#")[0]).is_file()
    style = "".join(re.findall("<style>(.*?)</style>", run[2], flags=re.DOTALL))
    assert "url(" not in style and "@import" not in style


def test_leads_with_the_results(parsed):
    ids = [attrs["id"] for tag, attrs, _ in parsed.elements if tag == "section"]
    assert ids == ["wall", "numbers", "best", "beside", "scores", "time", "rejected", "errors", "settings"]
    first = [attrs for tag, attrs, stack in parsed.elements if tag == "source" and "picture" in stack]
    assert len(first) == 4 and all("no-preference" in attrs["media"] for attrs in first)
    assert parsed.elements.index(("section", {"id": "wall"}, ("html", "body", "main"))) > max(
        number for number, (tag, _, _) in enumerate(parsed.elements) if tag == "source"
    )


def test_every_colour_is_defined_in_light_and_in_dark(run):
    style = re.search("<style>(.*?)</style>", run[2], flags=re.DOTALL).group(1)
    light, dark = (set(re.findall(r"(--[\w-]+):#", root)) for root in re.findall(r":root\{(.*?)\}", style))
    assert set(re.findall(r"var\((--[\w-]+)\)", style)) <= light == dark
    assert "@media (prefers-color-scheme:dark){:root{" in style


def test_is_the_same_every_time_and_everywhere(run, tmp_path):
    folder, _, text = run
    assert write_report(folder).read_text(encoding="utf-8") == text
    elsewhere = tmp_path / "another place" / folder.name
    shutil.copytree(folder, elsewhere)
    assert write_report(elsewhere).read_text(encoding="utf-8") == text
    assert not [path for path in folder.iterdir() if path.name.startswith(".")]


def test_every_transform_has_its_pictures(run):
    folder, transforms, _ = run
    shown = cards(folder)
    assert len(shown) == len(transforms)
    for card, transform in zip(shown, transforms, strict=True):
        n = len(transform)
        root = ET.fromstring(card)
        pictures = root.findall(".//svg")
        assert len(pictures) == 7  # two inputs, two results, two dissections, the chain
        uses = [len(picture.findall(".//use")) for picture in pictures]
        assert sorted(uses) == [0, 0, 0, 0, n, n, n]
        assert all(picture.find("title").text for picture in pictures)
        assert len(card.encode()) < 60_000


def test_a_piece_has_one_colour_on_the_whole_page(run):
    folder, transforms, _ = run
    for row, card, transform in zip(read_run(folder).constructed, cards(folder), transforms, strict=True):
        text = (folder / GALLERY / row.page).read_text(encoding="utf-8")
        n = len(transform)
        uses = [use.get("href") for use in ET.fromstring(card).iter("use")]
        (prefix,) = {use.rsplit("-", 1)[0] for use in uses}
        for k in range(n):
            assert uses.count(f"{prefix}-{k}") == 3
            defined = re.search(f'<g id="{prefix[1:]}-{k}"><path class="([^"]+)"', text)
            assert defined.group(1) == f"r-piece{hue(k, n)}"
        edges = re.findall(r'class="r-edge(\d)"', card)
        assert sorted(edges) == sorted(str(hue(k, n)) for k in range(n)) * 2 or len(edges) == 2 * n


def test_both_shapes_of_a_card_are_drawn_to_one_scale(run):
    for card in cards(run[0]):
        panels = ET.fromstring(card).find(".//div[@class='panels']")
        sizes = {tuple(svg.get("viewBox").split()[2:]) for svg in panels.iter("svg")}
        wide, high = ({int(size[axis]) for size in sizes} for axis in (0, 1))
        assert max(wide) - min(wide) <= 1 and max(high) - min(high) <= 1  # rounding of the corner


def test_numbers_are_those_of_the_tables(run):
    folder = run[0]
    for card, row in zip(cards(folder), read_run(folder).certified, strict=True):
        shown = "".join(ET.fromstring(card).find("dl").itertext())
        for value in (row.qcrs, row.crs, row.s_area, row.iou_p, row.bound_q, row.hausdorff_p, row.change_ratio):
            assert f"{value:.3f}" in shown
        assert "1.25 · 0.75" in shown and "1.5° · 2.5°" in shown


def test_the_papers_method_stands_beside(run):
    _, transforms, text = run
    section = ET.fromstring(re.search('<section id="beside">.*?</section>', text, flags=re.DOTALL).group(0))
    rows = [list(row.iter("td")) for row in section.iter("tr")][1:]
    assert len(rows) == fake_run.COMPARED + 1
    ious = [measure_deformation(transform).iou for transform in transforms[: fake_run.COMPARED]]
    for rank, (row, iou) in enumerate(zip(rows, ious, strict=False), start=1):
        assert row[0].find(".//a").get("href") == f"{GALLERY}/{rank:04d}.html"
        shown = ["".join(cell.itertext()) for cell in row[1:]]
        assert shown[:2] == [f"{iou:.3f}", f"{iou - 0.01 * rank:.3f}"]
        assert shown[3:6] == ["0.0121", "0.0232", "0.0343"] and shown[-1] == "0.0454"
    assert "".join(rows[-1][0].itertext()) == "median of 2"
    assert rows[-1][1].text == f"{sum(ious) / 2:.3f}"
    assert '<a href="#beside">' in text


def test_approximate_transforms_come_after_the_exact_ones(tmp_path):
    exact = fake_run.transforms(1)
    plan = same_trunks(exact[0], ConstructParameters().snap, 0.1)
    paper = construct_laplacian(plan, ConstructParameters())
    fake_run.write_fake_run(tmp_path, exact=exact, rejected=1, approximate=[paper])
    reported = read_run(tmp_path)
    assert [len(rows) for rows in (reported.certified, reported.approximate, reported.rejected)] == [1, 1, 1]
    assert reported.approximate[0].area_residual > 1e-6
    text = write_report(tmp_path).read_text(encoding="utf-8")
    pages = [(tmp_path / GALLERY / row.page).read_text(encoding="utf-8") for row in reported.constructed]
    assert ["No motion is planned for an approximate transform" in page for page in pages] == [False, True]
    assert (
        ["<animateTransform" in page for page in pages] == ['class="player"' in page for page in pages] == [True, False]
    )
    shown = "".join(Page(text).text)
    assert "exact and approximate transforms1 · 1" in shown and "(approximate)" in shown


def test_names_of_shapes_are_text(run, parsed):
    shown = "".join(parsed.text)
    for name in ("Tête & <b>'loup'</b>", 'qu"ote-é', "</script><svg onload=1>", "bad & <0>.png", "fake & <small>"):
        assert name in shown
    assert "cell 2 of <T> falls apart" in shown
    assert not re.search("[\x00-\x08\x0e-\x1f\x7f]", run[2])


def test_a_long_report_is_a_small_page(tmp_path):
    exact = [fake_run.transforms(1)[0]] * 120
    fake_run.write_fake_run(tmp_path, exact=exact, rejected=300, errors=300)
    facts = json.loads((tmp_path / "run.json").read_text())
    facts["files"] = {f"transforms/{k:04d}.riot": "ab" * 32 for k in range(2000)}
    (tmp_path / "run.json").write_text(json.dumps(facts))
    text = write_report(tmp_path).read_text(encoding="utf-8")
    page = Page(text)
    assert len(page.elements) < 5000 and len(text) < 400_000
    assert not page.all("animateTransform")
    pictures = [attrs for tag, attrs, stack in page.elements if tag == "img" and "picture" not in stack]
    assert len(pictures) == 100 and all(attrs["loading"] == "lazy" for attrs in pictures)


def test_histograms_count_everything(run):
    folder, _, text = run
    reported = read_run(folder)
    assert (reported.pairs, reported.pairs_without_trunks, reported.shapes, len(reported.classes)) == (780, 1, 40, 5)
    for plot in re.findall(r'<figure class="plot">.*?</figure>', text, flags=re.DOTALL):
        root = ET.fromstring(plot)
        total = int(re.search(r": (\d+) ", root.find("svg/title").text).group(1))
        bars = [int(re.search(r": (\d+) ", bar.find("title").text).group(1)) for bar in root.iter("rect")]
        assert sum(bars) == total > 0


def test_a_distribution_does_not_depend_on_how_it_arrives():
    values = np.random.default_rng(3).beta(2, 5, 10_001)
    values[:2] = 0.0, 1.0
    whole = distribution([values])
    in_chunks = distribution([np.append(chunk, np.nan) for chunk in np.array_split(values, 13)])
    assert np.array_equal(whole.cells, in_chunks.cells)
    assert whole.total == len(values)
    for share in (0.01, 0.5, 0.9, 0.999):
        assert whole.quantile(share) == pytest.approx(np.quantile(values, share), abs=2 / CELLS)
    assert (whole.least, whole.greatest) == (0.0, 1.0)
    assert np.isnan(distribution([]).quantile(0.5))


def test_a_run_that_found_nothing_has_a_report(tmp_path):
    fake_run.write_fake_run(tmp_path, exact=[], rejected=0, errors=0)
    for name in ("reversibility", "shapes"):
        fake_run.write_table(tmp_path, name, [])
    shutil.rmtree(tmp_path / "qcrs")
    fake_run.write(tmp_path / "qcrs" / "i_block=0000" / "part-0.parquet", tables.SCHEMAS["qcrs"], [])
    page = Page(write_report(tmp_path).read_text(encoding="utf-8"))
    shown = "".join(page.text)
    assert "No transform was constructed" in shown and "No construction was rejected" in shown
    assert "Beside the paper" not in shown
    assert not page.all("article")


def test_what_a_reader_could_wonder_about_is_said(tmp_path):
    fake_run.write_fake_run(tmp_path, exact=[], rejected=0)
    facts = json.loads((tmp_path / "run.json").read_text())
    facts["counts"] |= {"without_trunks": 2, "selected": 0, "classes": 1, "ignored_files": 1}
    facts["configuration"] = {"select": {"policy": "global"}}
    (tmp_path / "run.json").write_text(json.dumps(facts))
    page = Page(write_report(tmp_path).read_text(encoding="utf-8"))
    shown = "".join(page.text)
    assert len([paragraph for paragraph in page.all("p") if paragraph.get("class") == "remark"]) == 3
    assert "2 shapes have no trunk, so that every QCRS with them is 0" in shown
    assert "No pair was selected: select.policy=global pairs shapes of different classes" in shown
    assert "1 file was ignored" in shown


def test_residuals_of_any_size_are_markup():
    shown = [residual(value) for value in (0.0, 7e-16, 0.05, 3.0, 2e12, float("nan"))]
    assert shown == ["0", "7·10<sup>−16</sup>", "5·10<sup>−2</sup>", "3·10<sup>0</sup>", "2·10<sup>12</sup>", "–"]


def test_an_empty_qcrs_folder_is_a_run_without_pairs(tmp_path):
    fake_run.write_fake_run(tmp_path, exact=[])
    shutil.rmtree(tmp_path / "qcrs")
    (tmp_path / "qcrs").mkdir()
    assert read_run(tmp_path).pairs == 0
    write_report(tmp_path)


def test_a_lost_transform_does_not_stop_the_report(tmp_path):
    fake_run.write_fake_run(tmp_path, exact=fake_run.transforms(3))
    files = sorted((tmp_path / "transforms").iterdir())
    files[0].unlink()
    files[1].write_text('{"format": "riot-transform", "version": 99}')
    text = write_report(tmp_path).read_text(encoding="utf-8")
    page = Page(text)
    assert len(page.all("source")) == 1
    shown = "".join(page.text)
    assert f"transforms/{files[0].name} is gone" in shown and "has version 99" in shown
    assert str(tmp_path) not in text
    assert not [link["href"] for link in page.all("a") if link["href"].startswith(("gallery/0001", "gallery/0002"))]
    assert '<section id="beside">' in text


def test_many_errors_are_cut_and_counted(tmp_path):
    fake_run.write_fake_run(tmp_path, exact=[], errors=230)
    shown = "".join(Page(write_report(tmp_path).read_text(encoding="utf-8")).text)
    assert "30 more are in errors.parquet" in shown
    assert "bad <199>" in shown and "bad <200>" not in shown


@pytest.mark.parametrize("name", ["run.json", "crs.parquet"])
def test_an_unfinished_run_is_named(tmp_path, name):
    fake_run.write_fake_run(tmp_path, exact=[])
    (tmp_path / name).unlink()
    with pytest.raises(ReportError, match=re.escape(name)) as caught:
        write_report(tmp_path)
    assert isinstance(caught.value, FileNotFoundError)
    assert not (tmp_path / "report.html").exists()


def test_pieces_of_colour_pictures_show_them(tmp_path):
    folder = tmp_path / "coloured"
    folder.mkdir()
    transforms = fake_run.write_fake_run(folder, exact=fake_run.transforms(2))
    stripes = {"p": pattern_texture("stripes", transforms[0], "p")}
    (folder / "skins").mkdir()
    payload = encode(Artifact(pack_images(piece_images(transforms[0], stripes))))
    (folder / "skins" / "0001.skins").write_bytes(payload)
    write_report(folder)
    parsed = Page((folder / GALLERY / read_run(folder).constructed[0].page).read_text(encoding="utf-8"))
    assert not parsed.stack
    n, ids = len(transforms[0]), {attrs["id"] for _, attrs, _ in parsed.elements if "id" in attrs}
    images = parsed.all("image")
    assert len(images) == n and all(image["href"].startswith("data:image/jpeg;base64,") for image in images)
    shown, plain = cards(folder)
    uses = re.findall(r'<use href="#([^"]+)"', shown)
    assert set(uses) <= ids
    # P's dissection and the chain show the front, Q's dissection colours.
    assert sum("-p" in use for use in uses) == 2 * n and sum("-p" not in use for use in uses) == n
    assert "-p" not in "".join(re.findall(r'<use href="#([^"]+)"', plain))

"""What a notebook shows of shapes, trunks, plans, transforms and scores, and the frames that they become."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from html import unescape
from typing import Any
from urllib.parse import unquote

import numpy as np
import pytest

import riot
from riot.draw.animate import animate_svg, loop_times
from riot.draw.tuning import NOTEBOOK_PIXELS
from riot.groundtruth.pairs import exact_pair, exact_transform

SVG = "{http://www.w3.org/2000/svg}"
NAME = "a <b> & \"c\" 'd'"


@pytest.fixture(scope="module")
def transform() -> riot.Transform:
    exact: Any = exact_transform(exact_pair(5, 2))
    return replace(exact, p=exact.p.renamed(NAME))


@pytest.fixture(scope="module")
def house() -> riot.Shape:
    return riot.Shape.from_polygon([(0, 0), (4, 0), (4, 3), (2, 5), (0, 3)], name=NAME)


def picture(html: str) -> ET.Element:
    """The picture on a page of one image, which loads nothing else and has no id outside it."""
    (source,) = re.findall(r' src="([^"]*)"', html)
    assert source.startswith("data:image/svg+xml,") and " id=" not in html.replace(source, "")
    root = ET.fromstring(unquote(unescape(source).partition(",")[2]))
    assert root.tag == f"{SVG}svg"
    width, height = float(root.attrib["width"]), float(root.attrib["height"])
    assert 0 < width <= 2 * NOTEBOOK_PIXELS + 1 and 0 < height <= NOTEBOOK_PIXELS + 1
    assert f'width="{root.attrib["width"]}" height="{root.attrib["height"]}"' in html
    assert root.findall(f"{SVG}rect") == []  # the page is the background
    return root


def shown(html: str) -> str:
    """The text of a page, without its tags."""
    return unescape(re.sub(r"<script>.*</script>|<[^>]*>", "", html, flags=re.DOTALL))


def test_a_shape_is_its_outline_with_its_name(house: riot.Shape) -> None:
    html = house._repr_html_()
    assert len(picture(html).findall(f"{SVG}path")) == 2
    assert NAME in shown(html)
    assert ET.fromstring(house._repr_svg_()).findtext(f"{SVG}title", "").startswith(NAME)


@pytest.mark.parametrize("size", [(1, 1), (60, 1), (1, 60)])
def test_any_shape_fits(size: tuple[int, int]) -> None:
    shape = riot.Shape.from_polygon(np.array([(0, 0), (1, 0), (1, 1), (0, 1)]) * size)
    assert "<script" not in shape._repr_html_()
    picture(shape._repr_html_())


def test_trunks_are_shown_on_their_shape_and_as_a_table(house: riot.Shape) -> None:
    trunks = riot.trunks(house)
    every = trunks.on(house)
    assert every.numbers[0] == 0 and every.numbers[-1] == len(trunks) - 1
    paths = picture(every._repr_html_()).findall(f"{SVG}path")
    assert len(paths) == sum(2 + len(trunks.of(trunk)) for trunk in every.numbers)
    assert "trunks 3, 1 of" in shown(trunks.on(house, [3, 1])._repr_html_())
    assert "no trunks" in shown(trunks.on(house, [])._repr_html_())
    frame = riot.to_frame(trunks)
    assert frame.area.tolist() == trunks.areas.tolist()
    assert [len(vertices) for vertices in frame.vertices] == trunks.sizes.tolist()
    assert f"and {len(trunks) - 12} more rows" in shown(trunks._repr_html_())


def test_a_transform_swings_with_and_without_scripts(transform: riot.Transform) -> None:
    html = transform._repr_html_()
    root = picture(html)
    assert len(list(root.iter(f"{SVG}animateTransform"))) == 2 * len(transform)
    assert NAME in unescape(html) and html.count("<script>") == 1 and "$" not in html.partition("<script>")[2]
    assert html == transform._repr_html_()


@pytest.mark.parametrize("back", [False, True])
def test_the_slider_ends_where_the_pieces_lie_as_p_and_as_q(transform: riot.Transform, back: bool) -> None:
    transform = replace(transform, mirrored_q=back)
    times = loop_times(transform)
    for animation in ET.fromstring(animate_svg(transform)).iter(f"{SVG}animateTransform"):
        values = animation.attrib["values"].split(";")
        assert float(animation.attrib["dur"].rstrip("s")) == pytest.approx(times["duration"], rel=1e-3)
        steps = len(values) - 1

        def at(time: float, values: list[str] = values, steps: int = steps) -> str:
            position = time / times["duration"] * steps
            assert position == pytest.approx(round(position), abs=1e-6)
            return values[round(position)]

        way = [at(times["start"] + k * times["duration"] / steps) for k in range(steps // 2)]
        assert way[0] == values[0] and at(times["end"]) in values
        returns = [at(times["mirror"] - times["start"] - k * times["duration"] / steps) for k in range(steps // 2)]
        assert way == returns


def test_results_are_tables_and_frames(house: riot.Shape, transform: riot.Transform) -> None:
    certificate = riot.to_frame(transform.certificate())
    assert certificate["shape"].tolist() == ["P", "Q"] and certificate.passed.all()
    assert riot.to_frame(transform.deformation()).iou.tolist() == list(transform.overlap_ratios)
    score = riot.reversibility(house)
    assert riot.to_frame([score, score])[["rank", "score"]].to_numpy().tolist() == [[1, score.score], [2, score.score]]
    for result in (score, transform.certificate(), transform.deformation(), riot.crs(house, transform.q)):
        html: str = result._repr_html_()  # type: ignore[union-attr]
        headings = re.findall("<th>(.*?)</th>", html)
        assert headings == list(riot.to_frame(result).columns)
    for none in (7, "text", [7]):
        with pytest.raises(TypeError, match="no result"):
            riot.to_frame(none)


def test_a_plan_is_one_line_and_a_picture(house: riot.Shape) -> None:
    kite = riot.Shape.from_polygon([(0, 3), (-2, 0), (0, -2), (2, 0)], name="kite")
    plans = riot.alternatives(house, kite)
    assert all("\n" not in repr(plan) and "kite" in repr(plan) for plan in plans)
    picture(plans[0]._repr_html_())  # type: ignore[attr-defined]
    frame = riot.to_frame(plans)
    assert frame.iou_bound.tolist() == [plan.bound for plan in plans] and frame.iou_bound.is_monotonic_decreasing

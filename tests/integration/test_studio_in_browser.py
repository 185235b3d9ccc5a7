"""The studio in a browser, as a person uses it: from two pictures to parts, and what is done between."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image, ImageDraw
from studio_browser import (
    CHAIN,
    P,
    Q,
    browser,
    downloaded,
    exact,
    files,
    fresh,
    give_both,
    on_outline,
    open_page,
    served,
    shown,
    step,
)

from riot.transform.certificate import certify

__all__ = ["browser", "files", "fresh", "open_page", "served"]

pytestmark = pytest.mark.system

WAY_OF_A_PIECE = """view => {
    const pieces = [view, '[data-view=chain] svg'].map(svg => document.querySelector(`${svg} [data-piece]`));
    const screen = document.querySelector(`${view} .pieces`).getScreenCTM();
    const box = pieces[0].querySelector('.piece').getBBox();
    return pieces.map(piece => {
        const {matrix} = piece.transform.baseVal.consolidate();
        const at = new DOMPoint(box.x + box.width / 2, box.y + box.height / 2).matrixTransform(screen.multiply(matrix));
        return [at.x, at.y];
    });
}"""
"""Where the middle of a piece is on the screen in the picture of a shape, and where it would be as in the chain."""


TWO_FRAMES = "() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"


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
    page.locator("#certificate", has_text=re.compile("swings|needs")).wait_for()  # how it moves is planned after
    transform = downloaded(page)
    assert certify(transform).passed and transform.plan is not None

    step(page, "make")
    page.locator("#findings b").wait_for()  # it is built as soon as one looks
    page.locator("#settings [name=size_mm]").fill("90")
    page.click("#settings .primary")
    page.locator("#findings b", has_text=re.compile("holds|does not hold")).wait_for()
    page.locator(".labels li").nth(len(transform) - 1).wait_for()
    assert page.locator("#parts li", has_text="piece").count() == len(transform)
    turned = """import('/static/js/stl.js').then(({turnedOver}) => {
        const corner = {positions: new Float32Array([1, 2, 3]), normals: new Float32Array([0, 0, 1])};
        const {positions, normals} = turnedOver(corner, 9);
        return [...positions, ...normals];
    })"""
    assert page.evaluate(turned) == [1, -2, 6, 0, 0, -1]  # how parts that are printed upside down are shown
    sizes = [float(size) for size in re.findall(r"([\d.]+) ×", page.inner_text("#parts"))]
    assert sizes and max(sizes) < 100.0
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


def test_a_piece_of_either_shape_swings_by_pointer_and_finger_and_goes_back(
    fresh: Any, files: tuple[Path, Path]
) -> None:
    page = fresh
    give_both(page, files)
    page.locator("#certificate", has_text="swings").wait_for()  # how it moves is planned after
    page.locator("#status").wait_for(state="hidden")
    page.click("#play")
    slider, session = page.locator("#slider"), page.context.new_cdp_session(page)

    def touch(kind: str, *points: dict[str, float]) -> None:
        session.send("Input.dispatchTouchEvent", {"type": f"touch{kind}", "touchPoints": points})

    for view, rest, by_finger in ((P, 0.0, False), (Q, 1.0, True)):
        slider.fill("0.4")
        (x, y), (to_x, to_y) = page.evaluate(WAY_OF_A_PIECE, view)
        way = [{"x": x + k / 20 * (to_x - x), "y": y + k / 20 * (to_y - y)} for k in range(21)]
        assembled = shown(page, view)
        slider.fill(str(rest))
        if by_finger:
            touch("Start", way[0])
        else:
            page.mouse.move(**way[0])
            page.mouse.down()
        for point in way[1:]:
            touch("Move", point) if by_finger else page.mouse.move(**point)
        page.evaluate(TWO_FRAMES)  # moves are handled once a frame
        assert abs(float(slider.input_value()) - rest) > 0.1
        assert shown(page, view) == shown(page) != assembled
        touch("End") if by_finger else page.mouse.up()
        page.locator(f'{view} [data-piece][transform="{assembled[0]}"]').wait_for()
        assert shown(page, view) == assembled != shown(page)


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
    painted = page.locator("#pins li", has_text="softer part of house, 20 times")
    for tool, size, state in (("Soften", "0.1", "visible"), ("Erase", "0.4", "detached")):
        page.get_by_label(tool, exact=True).check()
        page.get_by_label("Brush").fill(size)
        page.locator(P).focus()
        for key in ("Enter", "Enter"):
            page.keyboard.press(key)
        painted.wait_for(state=state)
    assert page.locator(f"{P} .mark-stiff").count() == 0


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


def test_pieces_wear_the_colours_of_a_picture(fresh: Any, files: tuple[Path, Path], tmp_path: Path) -> None:
    page, picture = fresh, Image.new("RGB", (240, 240), "white")
    drawing = ImageDraw.Draw(picture)
    drawing.polygon([(20, 100), (120, 20), (220, 100), (220, 220), (20, 220)], fill="#d33")
    drawing.rectangle((80, 120, 160, 180), fill="#33d")
    picture.save(tmp_path / "house.png")
    give_both(page, (tmp_path / "house.png", files[1]))
    images = page.locator(f"{P} .texture image")
    images.first.wait_for()
    assert images.count() == page.locator(f"{P} [data-piece]").count()
    assert page.locator(f"{Q} .texture").count() == 0 and page.locator(f"{CHAIN} .texture").count() == images.count()
    page.get_by_label("textures").uncheck()
    assert not images.first.is_visible()
    page.get_by_label("textures").check()
    assert images.first.is_visible()


def test_without_colours_there_is_no_toggle_for_them(fresh: Any, files: tuple[Path, Path]) -> None:
    give_both(fresh, files)
    assert not fresh.get_by_label("textures").is_visible() and fresh.get_by_label("trunk").is_visible()

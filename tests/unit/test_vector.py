"""SVG files: what is filled, what is background, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import shapely

from riot import Shape
from riot.errors import SilhouetteError
from riot.geometry.silhouette import read
from riot.geometry.svg_outline import outline
from riot.parameters import ShapeParameters

HEAD = '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" viewBox="0 0 100 100">'


def write(folder: Path, body: str, head: str = HEAD) -> Path:
    path = folder / "drawing.svg"
    path.write_text(f"{head}{body}</svg>", encoding="utf-8")
    return path


def region(folder: Path, body: str, head: str = HEAD) -> shapely.Polygon:
    return shapely.Polygon(outline(write(folder, body, head)).points)


def reason(folder: Path, body: str, head: str = HEAD) -> str:
    with pytest.raises(SilhouetteError) as caught:
        read(write(folder, body, head))
    assert "drawing.svg" in str(caught.value)
    return caught.value.reason


@pytest.mark.parametrize(
    ("body", "area"),
    [
        ('<rect x="10" y="20" width="30" height="40"/>', 1200.0),
        ('<circle cx="50" cy="50" r="20"/>', 400.0 * np.pi),
        ('<ellipse cx="50" cy="50" rx="30" ry="10"/>', 300.0 * np.pi),
        ('<polygon points="10,10 50,10 10,50"/>', 800.0),
        ('<path d="M10 10h40v40h-40z M20 20v10h10v-10z"/>', 1600.0),
        ('<path d="M30 10 A20 20 0 0 1 30 50 Z"/>', 200.0 * np.pi),
        ('<path d="M0 0 Q 30 60 60 0 Z"/>', 2.0 / 3.0 * 60.0 * 30.0),
        ('<path d="M0 0 C 0 40 60 40 60 0 Z"/>', 60.0 * 40.0 * 0.6),
        ('<g transform="translate(5 5) scale(2)"><rect width="10" height="10"/></g>', 400.0),
        ('<rect width="10" height="10"/><rect x="5" width="20" height="10"/>', 250.0),
        ('<rect x="50" width="10" height="10"/><rect width="20" height="20"/>', 400.0),
        ('<defs><rect id="r" width="20" height="20"/></defs><use xlink:href="#r" x="5"/>', 400.0),
        ('<symbol id="s"><rect width="20" height="20"/></symbol><use href="#s"/><rect width="9" height="9"/>', 400.0),
        ('<rect width="20" height="20" style="fill:url(#g)"/><linearGradient id="g"><stop/></linearGradient>', 400.0),
        (
            '<style>.hide{fill:none}</style><rect class="hide" width="90" height="90"/><rect width="9" height="9"/>',
            81.0,
        ),
        ('<rect width="90" height="90" opacity="0"/><rect width="9" height="9" fill-opacity="50%"/>', 81.0),
        ('<rect width="90" height="90" visibility="hidden"/><rect width="9" height="9"/>', 81.0),
        ('<rect width="90" height="90" display="none"/><rect width="9" height="9"/>', 81.0),
    ],
)
def test_filled_area(tmp_path: Path, body: str, area: float) -> None:
    assert region(tmp_path, body).area == pytest.approx(area, rel=2e-3)


def test_fill_rules(tmp_path: Path) -> None:
    star = "M50 5 L79 91 L5 38 L95 38 L21 91 Z"
    full = region(tmp_path, f'<path d="{star}"/>').area
    points = region(tmp_path, f'<path d="{star}" fill-rule="evenodd"/>').area
    corners = shapely.LineString([(50, 5), (79, 91), (5, 38), (95, 38), (21, 91), (50, 5)])
    faces = shapely.get_parts(shapely.polygonize(shapely.get_parts(shapely.union_all([corners]))))
    areas = np.sort(shapely.area(faces))
    assert len(areas) == 6  # five tips and the middle, wound twice
    assert full == pytest.approx(areas.sum())
    assert points == pytest.approx(areas[:5].max())


@pytest.mark.parametrize(
    "background", ['<path d="M0 0h100v100H0z"/>', '<rect width="100%" height="100%" fill="#000"/>']
)
def test_icon_on_a_square(tmp_path: Path, background: str) -> None:
    icon = region(
        tmp_path, background + '<path fill="#fff" d="M20 20h60v60h-60z"/><rect x="20" y="20" width="30" height="30"/>'
    )
    assert icon.area == pytest.approx(3600.0 - 900.0)
    assert icon.centroid.x > 50.0


def test_a_lone_square_is_a_shape(tmp_path: Path) -> None:
    assert region(tmp_path, '<rect width="100" height="100"/>').area == pytest.approx(10_000.0)


def test_orientation_and_source(tmp_path: Path) -> None:
    path = write(tmp_path, '<polygon points="10,90 90,90 10,10"/>')  # right angle at the lower left
    shape = Shape.from_svg(path)
    assert shape.points[np.argmin(shape.points.sum(axis=1))] == pytest.approx(
        shape.from_source([[10.0, 90.0]])[0], abs=0.02
    )
    assert shape.source(shape.points).min(axis=0) == pytest.approx([10.0, 10.0], abs=0.2)
    assert read(path).points == pytest.approx(shape.points)


def test_no_view_box(tmp_path: Path) -> None:
    head = '<svg xmlns="http://www.w3.org/2000/svg">'
    both = '<rect width="50" height="50" fill="black"/><circle cx="25" cy="25" r="9" fill="white"/>'
    assert region(tmp_path, both, head).area == pytest.approx(81.0 * np.pi, rel=2e-3)


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("", "empty"),
        ("<text>Hello</text>", "unsupported"),
        ('<path d="M0 0 L10 10" fill="none" stroke="none"/>', "empty"),
        ('<rect x="200" width="9" height="9"/>', "empty"),
        ('<path d="M0 0 L10 10 Z"/>', "empty"),
        ('<image href="other.png"/>', "unsupported"),
        ('<use href="other.svg#icon"/>', "unsupported"),
        ('<style>@import "other.css";</style><rect width="9" height="9"/>', "unsupported"),
        ('<rect width="9" height="9" fill="url(other.svg#g)"/>', "unsupported"),
        ('<g id="a"><use href="#a"/></g>', "empty"),
        ("<rect", "unreadable"),
        ("<g>" * 3000 + "</g>" * 3000, "too-large"),
    ],
)
def test_refused(tmp_path: Path, body: str, expected: str) -> None:
    assert reason(tmp_path, body) == expected


def test_declarations_and_explosions_are_refused(tmp_path: Path) -> None:
    entity = '<!DOCTYPE svg [<!ENTITY file SYSTEM "file:///etc/hostname">]>' + HEAD
    assert reason(tmp_path, "<text>&file;</text>", entity) == "unsupported"
    wide = tmp_path / "wide.svg"
    wide.write_text(entity + "</svg>", encoding="utf-16")
    with pytest.raises(SilhouetteError, match="DOCTYPE"):
        read(wide)
    nested = '<g id="g0"><rect width="9" height="9"/></g>' + "".join(
        f'<g id="g{k + 1}">' + f'<use href="#g{k}"/>' * 10 + "</g>" for k in range(12)
    )
    assert reason(tmp_path, nested) == "too-large"


def test_other_xml_and_damage(tmp_path: Path) -> None:
    path = tmp_path / "page.svg"
    path.write_text("<!-- page --><html><body/></html>")
    with pytest.raises(SilhouetteError, match="no SVG") as caught:
        read(path)
    assert caught.value.reason == "unreadable"
    missing = tmp_path / "missing.svg"
    with pytest.raises(SilhouetteError, match=r"missing\.svg"):
        outline(missing)
    assert reason(tmp_path, '<path d="M0 0 L nan 5 L 5 5 Z"/>') in ("unreadable", "empty")
    assert reason(tmp_path, '<path d="M0 0 L 1e999 5 L 5 5 Z"/>') in ("unreadable", "empty", "degenerate")


def test_vector_and_parameters(tmp_path: Path) -> None:
    path = write(tmp_path, '<circle cx="50" cy="50" r="40"/>')
    coarse, fine = read(path, ShapeParameters(spacing=20.0)), read(path, ShapeParameters(spacing=200.0))
    assert len(fine.points) > 4 * len(coarse.points)

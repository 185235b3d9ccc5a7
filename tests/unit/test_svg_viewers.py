"""SVG files are read as browsers show them: what the outline is, or which feature is refused."""

from __future__ import annotations

import gzip
from pathlib import Path

import numpy as np
import pytest
import shapely

from riot.errors import SilhouetteError
from riot.geometry.silhouette import read
from riot.geometry.svg_outline import looks_like_svg, outline
from riot.types import FloatArray

HEAD = '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" viewBox="0 0 120 120">'
KITE = np.array([[60.0, 10.0], [100.0, 50.0], [60.0, 110.0], [20.0, 50.0]])
PATH = '<path class="kite" d="M60 10L100 50 60 110 20 50z"/>'
CARD = '<rect {} x="5" y="30" width="110" height="60"/>'
"""What must not be seen, or only as far as a clip path lets it."""


def drawing(folder: Path, body: str, head: str = HEAD) -> Path:
    path = folder / "drawing.svg"
    path.write_text(f"{head}{body}</svg>", encoding="utf-8")
    return path


def iou(points: FloatArray, region: shapely.Geometry) -> float:
    polygon = shapely.make_valid(shapely.Polygon(points))
    return float(polygon.intersection(region).area / polygon.union(region).area)


HIDDEN = {
    "a descendant": "<style>g rect{fill:none}</style><g>" + CARD + "</g>",
    "a child": "<style>g > rect{fill:none}</style><g>" + CARD + "</g>",
    "an attribute": "<style>[data-back]{fill:none}</style>" + CARD.format('data-back="1"'),
    "one of two classes": "<style>.a{fill:none}</style>" + CARD.format('class="b a"'),
    "the later of two rules": "<style>.a{fill:red}.b{fill:none}</style>" + CARD.format('class="b a"'),
    "the rule of an id": "<style>#a{fill:none} rect{fill:red}</style>" + CARD.format('id="a"'),
    "a style sheet at the end": CARD.format('class="a"') + "<style>.a{fill:none}</style>",
    "print": "<style>rect{fill:none} @media print{rect{fill:red}}</style>" + CARD,
    "a dark screen": "<style>rect{fill:none} @media (prefers-color-scheme: dark){rect{fill:red}}</style>" + CARD,
    "a pointer": "<style>rect{fill:none} rect:hover{fill:red}</style>" + CARD,
    "important": "<style>rect{fill:none !important}</style>" + CARD.format('style="fill:red"'),
    "display": CARD.format('style="display:none !important"'),
    "inherit": '<g fill="none">' + CARD.format('fill="inherit"') + "</g>",
    "currentColor": '<g color="transparent">' + CARD.format('fill="currentColor"') + "</g>",
    "a product of opacities": '<g opacity="0">' + CARD.format('opacity="1"') + "</g>",
    "a colour without opacity": CARD.format('fill="rgba(0,0,0,0)"'),
    "a gradient without opacity": '<linearGradient id="g"><stop stop-opacity="0"/></linearGradient>'
    + CARD.format('fill="url(#g)"'),
    "no paint of this name": CARD.format('fill="url(#absent) none"'),
    "a use without fill": "<defs>" + CARD.format('id="c"') + '</defs><use xlink:href="#c" fill="none"/>',
    "a symbol that is not used": "<symbol>" + CARD + "</symbol>",
    "a switch": '<switch><g systemLanguage="xx">' + CARD + '</g><rect width="1" height="1"/></switch>',
    "text that flows": "<flowRoot><flowRegion>" + CARD + "</flowRegion></flowRoot>",
    "beside the page": CARD.format('transform="translate(200 0)"'),
    "an attribute without value": '<g fill="none">' + CARD.format('fill=""') + "</g>",
    "a percentage": CARD.format('opacity="0%"'),
    "no feature": '<switch><rect requiredFeatures="absent" width="1" height="1"/>' + CARD + "</switch>",
    "an extension": '<foreignObject requiredExtensions="http://ns.example/"><g>' + CARD + "</g></foreignObject>",
}


@pytest.mark.parametrize("kind", HIDDEN)
def test_what_a_viewer_does_not_show_is_no_part_of_the_shape(tmp_path: Path, kind: str) -> None:
    found = outline(drawing(tmp_path, HIDDEN[kind].replace("{}", "") + PATH))
    assert iou(found.points, shapely.Polygon(KITE)) > 0.998


BOX = shapely.box(5.0, 30.0, 115.0, 90.0)
LINE = shapely.LineString([(20, 20), (100, 20), (100, 100)])
SEEN = {
    "a clip path by class": (
        '<style>.c{clip-path:url(#k)}</style><clipPath id="k"><path d="M60 10L100 50 60 110 20 50z"/></clipPath>'
        '<g class="c">' + CARD + "</g>",
        BOX & shapely.Polygon(KITE),
    ),
    "a mask by style": (
        '<mask id="k"><rect width="120" height="120" fill="white"/><rect width="60" height="120"/></mask>'
        '<g style="mask:url(#k)">' + CARD + "</g>",
        BOX & shapely.box(60, 0, 120, 120),
    ),
    "a clip path of one rectangle": (
        '<clipPath id="k"><rect x="20" y="40" width="30" height="20"/></clipPath><g clip-path="url(#k)">'
        + CARD
        + "</g>",
        shapely.box(20, 40, 50, 60),
    ),
    "a drawing in the drawing": (
        '<svg x="20" y="20" width="50" height="40">' + CARD + "</svg>",
        shapely.box(25, 50, 70, 60),
    ),
    "across the page's edge": ('<circle cx="120" cy="60" r="50"/>', shapely.Point(120, 60).buffer(50, 256)),
    "the origin of a transform": (
        '<rect x="40" y="50" width="40" height="20" transform="rotate(90)" transform-origin="60 60"/>',
        shapely.box(50, 40, 70, 80),
    ),
    "a stroke": ('<path d="M20 20H100V100" fill="none" stroke="#000" stroke-width="16"/>',
                 LINE.buffer(8, cap_style="flat", join_style="mitre")),
    "a stroke beside a fill": (
        CARD.format("") + '<path d="M20 20H100V100" fill="none" stroke="#000" stroke-width="16"/>',
        shapely.Polygon((BOX | LINE.buffer(8, cap_style="flat", join_style="mitre")).exterior),
    ),
    "a broad stroke": (CARD.format('stroke="#000" stroke-width="10"'), shapely.box(0, 25, 120, 95)),
    "a line of one pixel around": (
        '<path d="M20 20H100V100H20z" fill="none" stroke="#000" stroke-width=".5"/>',
        shapely.box(19.75, 19.75, 100.25, 100.25),
    ),
    "a symbol that is used": (
        '<symbol id="s" viewBox="0 0 2 2"><rect width="2" height="1"/></symbol>'
        '<use href="#s" x="20" y="30" width="60" height="60"/>',
        shapely.box(20, 30, 80, 60),
    ),
    "a small object on a large page": ('<path d="M50 50h1l-.5 1.5z"/><path d="M9 9h.1v.1z" opacity=".9"/>',
                                       shapely.Polygon([(50, 50), (51, 50), (50.5, 51.5)])),
    "a pattern": (
        '<pattern id="p" width="4" height="4" patternUnits="userSpaceOnUse"><rect width="4" height="4"/></pattern>'
        + CARD.format('fill="url(#p)"'),
        BOX,
    ),
}  # fmt: skip


@pytest.mark.parametrize("kind", SEEN)
def test_what_a_viewer_shows_is_the_shape(tmp_path: Path, kind: str) -> None:
    body, region = SEEN[kind]
    found = outline(drawing(tmp_path, body.replace("{}", "")))
    assert iou(found.points, region & shapely.box(0, 0, 120, 120)) > 0.996


REFUSED = {
    "text": ("<text>A</text>", "text"),
    "a picture": ('<image href="data:image/png;base64,AAAA"/>', "embedded picture"),
    "HTML": ("<foreignObject/>", "foreignObject"),
    "an animation": ('<rect><set attributeName="width" to="9"/></rect>', "animated"),
    "a later sibling": ("<style>path~rect{fill:none}</style>", "path~rect"),
    "a count of siblings": ("<style>rect:nth-of-type(2){fill:none}</style>", "nth-of-type"),
    "a negation": ("<style>rect:not(.a){fill:none}</style>", ":not"),
    "the root": ("<style>:root{fill:none}</style>", ":root"),
    "the start of an attribute": ("<style>[id^=a]{fill:none}</style>", "id^=a"),
    "a variable": ('<g style="fill:var(--c)"/>', "var"),
    "a screen": ("<style>@media screen{rect{fill:none}}</style>", "@media screen"),
    "a layer": ("<style>@layer a{rect{fill:none}}</style>", "@layer"),
    "nesting": ("<style>g{rect{fill:none}}</style>", "g"),
    "a sheet for print": ('<style media="print">rect{fill:none}</style>', "print"),
    "transform as CSS": ('<g style="transform:rotate(5deg)"/>', "CSS property transform"),
    "transform in a sheet": ("<style>g{transform:rotate(5deg)}</style>", "CSS property transform"),
    "transform-box": ('<g transform-box="fill-box"/>', "transform-box"),
    "a size as CSS": ("<style>rect{width:9px}</style>", "CSS property width"),
    "a colour with a slash": ('<g fill="rgb(0 0 0 / 0%)"/>', "rgb(0 0 0 / 0%)"),
    "a colour of a new kind": ('<g fill="oklch(0 0 0)"/>', "oklch"),
    "unset": ('<g fill="unset"/>', "unset"),
    "a declaration without value": ("<style>rect{broken;fill:none}</style>", "broken"),
    "an opacity in percent": ('<g fill="rgba(0,0,0,0%)"/>', "rgba(0,0,0,0%)"),
    "an angle in degrees": ('<g fill="hsla(120deg,100%,50%,0)"/>', "deg"),
    "no name of a colour": ('<g fill="NONE"/>', "NONE"),
    "a word in capitals": ('<g display="NONE"/>', "NONE"),
    "a filter that is not there": ('<g filter="url(#absent)"/>', "filter"),
    "a property with a prefix": ('<g style="-webkit-mask:url(#a)"/>', "-webkit-mask"),
    "a calculation": ('<g opacity="calc(1 - 1)"/>', "calc"),
    "a clip path as a function": ('<g style="clip-path:circle(9px)"/>', "circle"),
    "a stroke that keeps its width": ('<g vector-effect="non-scaling-stroke"/>', "non-scaling-stroke"),
    "another file's style": ('<style>@import "a.css";</style>', "another file"),
}


@pytest.mark.parametrize("kind", REFUSED)
def test_what_is_not_drawn_as_in_a_browser_is_refused_by_its_name(tmp_path: Path, kind: str) -> None:
    body, words = REFUSED[kind]
    with pytest.raises(SilhouetteError, match=r"drawing\.svg.*;") as caught:
        read(drawing(tmp_path, body + PATH))
    assert caught.value.reason == "unsupported" and words in str(caught.value)


WRITTEN = {
    "a DOCTYPE": '<?xml version="1.0"?>\n<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" '
    f'"http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd">{HEAD}{PATH}</svg>',
    "a prefix": '<ns0:svg xmlns:ns0="http://www.w3.org/2000/svg" viewBox="0 0 120 120">'
    '<ns0:path d="M60 10L100 50 60 110 20 50z"/></ns0:svg>',
    "blank lines": "\n" * 300 + f"{HEAD}{PATH}</svg>",
    "no namespace": f'<svg viewBox="0 0 120 120">{PATH}</svg>',
}


@pytest.mark.parametrize("kind", WRITTEN)
@pytest.mark.parametrize("packed", [False, True])
def test_other_ways_to_write_the_same_file(tmp_path: Path, kind: str, packed: bool) -> None:
    path = tmp_path / ("drawing.svgz" if packed else "drawing.svg")
    data = WRITTEN[kind].encode()
    path.write_bytes(gzip.compress(data) if packed else data)
    assert looks_like_svg(path)
    found = outline(path)
    assert not found.rendered and iou(found.points, shapely.Polygon(KITE)) > 1.0 - 1e-9


def test_compressed_files_may_be_damaged_or_too_large(tmp_path: Path) -> None:
    path = tmp_path / "drawing.svgz"
    data = gzip.compress(f"{HEAD}{PATH}</svg>".encode())
    path.write_bytes(data[:-30])
    with pytest.raises(SilhouetteError, match=r"XML|damaged"):
        read(path)
    path.write_bytes(gzip.compress(HEAD.encode() + bytes(30_000_000)))
    with pytest.raises(SilhouetteError, match="limit of") as caught:
        read(path)
    assert caught.value.reason == "too-large"


def test_the_outline_of_pixels_is_as_fine_as_that_of_paths(tmp_path: Path) -> None:
    exact = outline(drawing(tmp_path, PATH))
    pixels = outline(drawing(tmp_path, f'<g opacity=".99">{PATH}</g>'))
    assert (exact.rendered, pixels.rendered) == (False, True)
    lengths = np.linalg.norm(np.diff(KITE, axis=0, append=KITE[:1]), axis=1)
    region = shapely.Polygon(exact.points)
    unit = 2.0 * np.sqrt(np.pi * region.area)
    distances = shapely.distance(region.exterior, shapely.points(pixels.points))
    assert lengths.sum() > unit and distances.mean() < 2e-4 * unit and distances.max() < 1e-3 * unit


def test_a_drawing_without_size_needs_one_unless_it_is_plain(tmp_path: Path) -> None:
    head = '<svg xmlns="http://www.w3.org/2000/svg">'
    assert iou(outline(drawing(tmp_path, PATH, head)).points, shapely.Polygon(KITE)) > 0.9999
    with pytest.raises(SilhouetteError, match="viewBox"):
        outline(drawing(tmp_path, f'<g opacity=".5">{PATH}</g>', head))

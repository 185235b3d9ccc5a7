"""Shapes of polygons as other libraries have them, and of pixels in memory; GeoJSON of shapes and of pieces."""

from __future__ import annotations

import json
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
import shapely.geometry
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from riot import Shape
from riot.errors import SilhouetteError
from riot.groundtruth.pairs import exact_pair, exact_transform
from riot.parameters import ShapeParameters

RING = [(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (2.0, 5.0), (0.0, 3.0)]
HOUSE = shapely.Polygon(RING)
GEOJSON = {"type": "Polygon", "coordinates": [[*RING, RING[0]]]}
HOLED = shapely.Polygon(RING, [[(1, 1), (2, 1), (2, 2)], [(2.5, 2.5), (3, 2.5), (3, 3)]])


@pytest.mark.parametrize(
    "polygon",
    [
        HOUSE,
        shapely.Polygon(RING[::-1]),
        shapely.force_3d(HOUSE, 7.0),
        shapely.MultiPolygon([HOUSE]),
        shapely.GeometryCollection([HOUSE]),
        shapely.LinearRing(RING),
        GEOJSON,
        json.loads(json.dumps(GEOJSON)),
        {"type": "Feature", "properties": None, "geometry": GEOJSON},
        {"type": "FeatureCollection", "features": [{"type": "Feature", "properties": {}, "geometry": GEOJSON}]},
    ],
    ids=lambda polygon: getattr(polygon, "geom_type", None) or polygon["type"],
)
def test_a_polygon_is_the_same_shape_whoever_holds_it(polygon: Any) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert Shape.from_polygon(polygon, "house") == Shape.from_polygon(RING, "house")


def test_holes_are_filled_and_counted() -> None:
    with pytest.warns(UserWarning, match="fort: 2 holes are filled") as caught:
        shape = Shape.from_polygon(HOLED, "fort")
    assert shape == Shape.from_polygon(RING, "fort")
    assert caught[0].filename == __file__


@pytest.mark.parametrize(
    ("polygon", "reason", "words"),
    [
        (shapely.Polygon(), "empty", "empty"),
        (shapely.MultiPolygon([HOUSE, shapely.box(9, 9, 10, 10)]), "several", "2 polygons"),
        (shapely.Point(1, 2), "unreadable", "Point"),
        (shapely.LineString(RING), "unreadable", "LineString"),
        ({"type": "Polygon", "coordinates": [["a", "b"]]}, "unreadable", "GeoJSON"),
        ({"kind": "Polygon"}, "unreadable", "GeoJSON"),
        ({"type": "Feature", "properties": {}, "geometry": None}, "empty", "no polygon"),
        ("house.png", "unreadable", "array"),
    ],
)
def test_what_is_no_polygon_is_told(polygon: Any, reason: str, words: str) -> None:
    with pytest.raises(SilhouetteError, match=words) as caught:
        Shape.from_polygon(polygon)
    assert caught.value.reason == reason


@given(st.integers(4, 8), st.integers(0, 1000))
def test_a_shape_goes_through_geojson_unchanged_in_form(n: int, seed: int) -> None:
    drawn = np.random.default_rng(seed)
    angles = 2.0 * np.pi * (np.arange(n) + drawn.uniform(0.0, 0.7, n)) / n
    radii = drawn.uniform(1.0, 3.0, n)[:, None]
    shape = Shape.from_polygon(np.column_stack([np.cos(angles), np.sin(angles)]) * radii, "polygon")
    feature = json.loads(json.dumps(shape.__geo_interface__))
    ring = feature["geometry"]["coordinates"][0]
    assert ring[0] == ring[-1]
    assert np.array_equal(ring[:-1], shape.points)
    again = Shape.from_polygon(feature)
    assert again.name == "polygon"
    assert shapely.Polygon(again.points).symmetric_difference(shapely.Polygon(shape.points)).area < 1e-3


def test_the_pieces_of_a_transform_tile_both_shapes() -> None:
    transform = exact_transform(exact_pair(5, 2))
    features = json.loads(json.dumps(transform.__geo_interface__))["features"]
    for side, outline in (("P", transform.outline_p()), ("Q", transform.outline_q())):
        parts = [feature for feature in features if feature["properties"]["shape"] == side]
        assert [feature["properties"]["piece"] for feature in parts] == list(range(len(transform)))
        polygons = [shapely.geometry.shape(feature) for feature in parts]
        assert all(polygon.exterior.is_ccw for polygon in polygons)
        assert sum(polygon.area for polygon in polygons) == pytest.approx(1.0, abs=1e-6)
        assert shapely.union_all(polygons).symmetric_difference(shapely.Polygon(outline)).area < 1e-6


def disc() -> Any:
    rows, columns = np.mgrid[:64, :64]
    return np.clip(21.0 - np.hypot(rows - 30.0, columns - 33.0), 0.0, 1.0)


def test_pixels_are_the_same_shape_in_a_file_in_an_array_and_in_an_image(tmp_path: Path) -> None:
    grey = np.rint(disc() * 255.0).astype(np.uint8)
    Image.fromarray(grey).save(tmp_path / "disc.png")
    from_file = Shape.from_image(tmp_path / "disc.png")
    colour = np.stack([grey] * 3, axis=-1)
    opacity = np.dstack([np.zeros_like(colour), grey])
    pixels = [grey, grey[:, :, None], colour, colour / 255.0, opacity, np.dstack([grey * 0, grey])]
    for image in [*pixels, Image.fromarray(grey), Image.fromarray(opacity)]:
        assert Shape.from_image(image, name="disc") == from_file
    with Image.open(tmp_path / "disc.png") as image:
        assert Shape.from_image(image) == from_file
    sharp = disc() > 0.5
    assert Shape.from_image(sharp) == Shape.from_image(np.stack([sharp] * 3, axis=-1))
    assert Shape.from_image(tmp_path / "disc.png", name="coin").name == "coin"


@pytest.mark.parametrize(
    ("pixels", "reason"),
    [
        (np.zeros((5, 5, 7)), "unreadable"),
        (np.zeros(9), "unreadable"),
        (np.full((9, 9, 3), 300), "unreadable"),
        (np.full((9, 9, 3), np.nan), "unreadable"),
        ([[1, 2], [3]], "unreadable"),
        (np.zeros((9, 9), dtype=np.uint8), "one-colour"),
        (Image.new("L", (9, 9)), "one-colour"),
        (None, "unreadable"),
    ],
)
def test_what_is_no_picture_is_told(pixels: Any, reason: str) -> None:
    with pytest.raises(SilhouetteError) as caught:
        Shape.from_image(pixels)
    assert caught.value.reason == reason


def test_the_limit_of_pixels_is_for_arrays_and_images_too() -> None:
    limit = ShapeParameters(max_pixels=100)
    for pixels in (disc(), np.dstack([disc()] * 3), Image.new("L", (64, 64))):
        with pytest.raises(SilhouetteError, match="limit of 100"):
            Shape.from_image(pixels, limit)

"""Boxes in rows, and parts nested on a raster: apart, within their sheets, and close."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from riot.fabricate.export.nesting import nest
from riot.fabricate.shelves import shelves


def test_shelves_keep_boxes_apart_and_on_their_pages() -> None:
    sizes = np.random.default_rng(1).uniform(5.0, 60.0, (40, 2))
    sizes[0] = (150.0, 20.0)
    spots = shelves(sizes, 100.0, 160.0, 4.0)
    assert spots[0].turned
    boxes = []
    for spot, size in zip(spots, sizes, strict=True):
        wide, high = size[::-1] if spot.turned else size
        assert 0.0 <= spot.x <= spot.x + wide <= 100.0
        assert 0.0 <= spot.y <= spot.y + high <= 160.0
        boxes.append((spot.page, shapely.box(spot.x, spot.y, spot.x + wide, spot.y + high)))
    for i, (page, box) in enumerate(boxes):
        assert all(page != other or box.distance(near) > 3.99 for other, near in boxes[:i])
    assert 1 < len({page for page, _ in boxes}) < 8
    with pytest.raises(ValueError, match="does not fit"):
        shelves(np.array([[120.0, 170.0]]), 100.0, 160.0, 4.0)


def blob(generator: np.random.Generator) -> shapely.Polygon:
    """A star-shaped region, 20 to 60 mm across."""
    angles = np.sort(generator.uniform(0.0, 2.0 * np.pi, 12))
    radii = generator.uniform(10.0, 30.0, 12)
    return shapely.Polygon(np.column_stack([radii * np.cos(angles), radii * np.sin(angles)])).buffer(1.0)


@pytest.mark.parametrize("seed", range(3))
def test_nested_parts_keep_apart_and_on_their_sheets(seed: int) -> None:
    generator = np.random.default_rng(seed)
    parts = [blob(generator) for _ in range(24)]
    spots = nest(parts, 150.0, 100.0, 4.0)
    inner = shapely.box(0.0, 0.0, 150.0, 100.0).buffer(-3.9)
    placed = [(spot.sheet, spot.place(part)) for spot, part in zip(spots, parts, strict=True)]
    for i, (sheet, region) in enumerate(placed):
        assert inner.contains(region)
        assert region.area == pytest.approx(parts[i].area)
        assert all(sheet != other or region.distance(near) > 3.99 for other, near in placed[:i])


def test_nesting_uses_the_room_between_parts() -> None:
    """Two triangles lie in the room of their common box: rows of boxes would take two sheets."""
    triangle = shapely.Polygon([(0.0, 0.0), (90.0, 0.0), (0.0, 90.0)])
    assert [spot.sheet for spot in nest([triangle, triangle], 112.0, 112.0, 2.0)] == [0, 0]


def test_a_part_larger_than_the_sheet_is_named() -> None:
    with pytest.raises(ValueError, match="larger") as raised:
        nest([shapely.box(0.0, 0.0, 10.0, 10.0), shapely.box(0.0, 0.0, 130.0, 10.0)], 100.0, 100.0, 2.0)
    assert raised.value.args[1] == 1

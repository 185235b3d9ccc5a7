"""Damaged files are shapes, transforms and pins, or the project's own errors, in bounded memory.

A short form runs by default; ``pytest -m fuzz`` runs the long one.
"""

from __future__ import annotations

import resource
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from fuzz.damage import Damage, damaged, damages, drawings, pictures, transforms
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from riot.construction.pins import pins_from_json
from riot.construction.stiff import stiff_from_json
from riot.errors import FormatError, SilhouetteError
from riot.geometry.silhouette import polygon_shape, read
from riot.groundtruth.pairs import exact_pair
from riot.transform.riot_file import from_json, load, to_json

MEMORY = 600 * 2**20
"""By how much the process may grow, in bytes, over all damaged files: they are some kilobytes each."""

PICTURES, DRAWINGS, TRANSFORMS = pictures(), drawings(), transforms()
PINS = [
    b'{"format":"riot-pins","version":1,"frame":"source","p":[{"keep":[[1,2],[3,4.5]]}],"q":[{"draw":[[0,0],[1,1]]}]}'
]
STIFF = [
    b'{"format":"riot-stiff","version":1,"frame":"source","p":[{"polygon":[[1,2],[3,4.5],[0,9]],"factor":20}],"q":[]}'
]
SHAPE = polygon_shape(exact_pair(3, 1).p)


def silhouette(data: bytes) -> None:
    """Read as a picture or drawing: a shape that is one, or an error that names the file."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "damaged.file"
        path.write_bytes(data)
        try:
            shape = read(path)
        except SilhouetteError as error:
            assert "damaged.file" in str(error) and error.reason and len(str(error)) < 1000
        else:
            assert np.isfinite(shape.points).all() and np.isfinite(shape.to_source).all()


def transform(data: bytes) -> None:
    """Read as a transform: one that can be written, judged and read again, or an error that names the file."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "damaged.riot"
        path.write_bytes(data)
        try:
            made = load(path)
        except FormatError as error:
            assert "damaged.riot" in str(error) and len(str(error)) < 1000
        else:
            text = to_json(made)
            assert to_json(from_json(text)) == text


def pins(data: bytes) -> None:
    """Read as pins: points that are numbers, or an error that names the file."""
    try:
        found = pins_from_json(data.decode("utf-8", errors="replace"), SHAPE, SHAPE, "damaged.json")
    except FormatError as error:
        assert "damaged.json" in str(error)
    else:
        assert all(np.isfinite(pin.points).all() for pin in (*found.p, *found.q))


def stiff(data: bytes) -> None:
    """Read as stiff regions: polygons that are numbers, or an error that names the file."""
    try:
        regions = stiff_from_json(data.decode("utf-8", errors="replace"), SHAPE, SHAPE, "damaged.json")
    except FormatError as error:
        assert "damaged.json" in str(error)
    else:
        assert all(np.isfinite(polygon).all() and factor > 0.0 for polygon, factor in (*regions.p, *regions.q))


READERS: dict[str, tuple[Callable[[bytes], None], list[bytes], int]] = {
    "pictures": (silhouette, PICTURES, 60),
    "drawings": (silhouette, DRAWINGS, 60),
    "transforms": (transform, TRANSFORMS, 60),
    "pins": (pins, PINS, 60),
    "stiff": (stiff, STIFF, 60),
}
"""What reads, what is damaged, and how many files of it are tried in the short form."""

LONG = 50
"""Times as many in the long form."""


def tried(name: str, examples: int) -> None:
    """Damage so many files and read them."""
    reader, files, _ = READERS[name]

    @settings(
        max_examples=examples,
        derandomize=examples == READERS[name][2],  # the short form is the same every time
        database=None,
        phases=[Phase.generate, Phase.shrink],
        suppress_health_check=list(HealthCheck),
    )
    @given(st.sampled_from(files), st.sampled_from([*PICTURES, *DRAWINGS, *TRANSFORMS]), damages())
    def damage(data: bytes, other: bytes, done: list[Damage]) -> None:
        reader(damaged(data, other, done))

    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    damage()
    grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) * 1024
    assert grown < MEMORY


@pytest.mark.parametrize("name", sorted(READERS))
def test_damaged_files_end_in_our_own_errors(name: str) -> None:
    tried(name, READERS[name][2])


@pytest.mark.fuzz
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("name", sorted(READERS))
def test_many_damaged_files_end_in_our_own_errors(name: str) -> None:
    tried(name, READERS[name][2] * LONG)


COORDINATES = st.floats() | st.integers(-5, 5).map(float) | st.sampled_from([1e300, -1e-300, 1e15])


@settings(max_examples=150, derandomize=True)
@given(st.lists(st.tuples(COORDINATES, COORDINATES), max_size=12))
def test_any_polygon_is_a_shape_or_our_own_error(corners: list[tuple[float, float]]) -> None:
    try:
        shape = polygon_shape(corners)
    except SilhouetteError as error:
        assert error.reason
    else:
        assert (
            abs(
                float(np.dot(shape.points[:, 0], np.roll(shape.points[:, 1], -1) - np.roll(shape.points[:, 1], 1)))
                - 2.0
            )
            < 1e-9
        )


@pytest.mark.parametrize("name", sorted(READERS))
def test_undamaged_files_are_read(name: str) -> None:
    """Else the damaged ones would try nothing but the first refusal."""
    reader, files, _ = READERS[name]
    for data in files:
        if reader is silhouette:
            with tempfile.TemporaryDirectory() as folder:
                (Path(folder) / "whole").write_bytes(data)
                assert len(read(Path(folder) / "whole").points) > 50
        elif reader is transform:
            assert to_json(from_json(data.decode())).encode() == data
        elif reader is stiff:
            assert stiff_from_json(data.decode(), SHAPE, SHAPE).p
        else:
            assert pins_from_json(data.decode(), SHAPE, SHAPE)

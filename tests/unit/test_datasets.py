"""Collections: names, classes, order, duplicates, and what is said when there is nothing."""

from __future__ import annotations

import os
import subprocess
import sys
import unicodedata
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from pipeline.datasets import collection as datasets
from pipeline.datasets import sample
from pipeline.datasets.collection import Collection, DatasetConfig, DatasetError, class_of, collect
from pipeline.datasets.reading import open_item
from riot.errors import RiotError, SilhouetteError
from riot.geometry.polyline import is_simple


def picture(path: Path, radius: float = 20.0) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    rows, columns = np.mgrid[:60, :60]
    image = np.where((columns - 30) ** 2 + (rows - 30) ** 2 <= radius**2, 255, 0).astype(np.uint8)
    Image.fromarray(image).save(path)
    return path


def folder(root: Path, **options: object) -> Collection:
    return collect(DatasetConfig("mine", "folder", root=str(root), **options))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("apple-1", "apple"),
        ("sea_snake-12", "sea_snake"),
        ("device0-3", "device0"),
        ("horse_007", "horse"),
        ("a-b-3", "a-b"),
        ("plain", ""),
        ("plain7", ""),
        ("-3", ""),
        ("cat-tail", ""),
        ("birds/eagle-1", "birds"),
        ("a/b/x", "a/b"),
    ],
)
def test_class_rule(name: str, expected: str) -> None:
    assert class_of(name) == expected


def test_listing(tmp_path: Path) -> None:
    picture(tmp_path / "zoo" / "été 2.PNG", 21)
    picture(tmp_path / "apple-10.png", 10)
    picture(tmp_path / "apple-9.gif", 11)
    picture(tmp_path / "twin.png", 12)
    picture(tmp_path / "twin.bmp", 13)
    picture(tmp_path / ".hidden.png", 14)
    picture(tmp_path / ".cache" / "x.png", 15)
    (tmp_path / "readme.txt").write_text("no picture")
    (tmp_path / "text.png").write_text("no picture either")
    found = folder(tmp_path)
    assert [item.name for item in found.items] == [
        "apple-10", "apple-9", "text", "twin.bmp", "twin.png", "zoo/été 2"
    ]  # fmt: skip
    assert [item.cls for item in found.items] == ["apple", "apple", "", "", "", "zoo"]
    assert found.ignored == 2
    assert found.rejected == ()
    assert open_item(found.items[-1]).name == "zoo/été 2"
    with pytest.raises(SilhouetteError) as caught:
        open_item(found.items[2])
    assert caught.value.reason == "not-a-picture"


def test_names_do_not_depend_on_how_accents_are_stored(tmp_path: Path) -> None:
    one, two = tmp_path / "one", tmp_path / "two"
    picture(one / unicodedata.normalize("NFC", "étoile-1.png"))
    picture(two / unicodedata.normalize("NFD", "étoile-1.png"))
    a, b = folder(one).items[0], folder(two).items[0]
    assert (a.name, a.cls, a.digest) == (b.name, b.cls, b.digest)
    picture(one / unicodedata.normalize("NFD", "étoile-1.png"), 9)
    names = [item.name for item in folder(one).items]
    assert len(set(names)) == 2


def test_duplicates_keep_the_first_name(tmp_path: Path) -> None:
    for name in ("c.png", "a.png", "sub/b.png"):
        picture(tmp_path / name)
    picture(tmp_path / "d.png", 5)
    found = folder(tmp_path)
    assert [item.name for item in found.items] == ["a", "d"]
    assert [(row.name, row.reason) for row in found.rejected] == [("c", "duplicate"), ("sub/b", "duplicate")]
    assert "the same bytes as a" in found.rejected[0].message


def test_links_do_not_lead_out(tmp_path: Path) -> None:
    secret = picture(tmp_path / "outside" / "secret.png", 7)
    root = tmp_path / "root"
    inside = picture(root / "inside.png")
    (root / "leak.png").symlink_to(secret)
    (root / "folder").symlink_to(secret.parent, target_is_directory=True)
    (root / "broken.png").symlink_to(root / "nothing.png")
    (root / "within.png").symlink_to(inside)
    (root / "ring.png").symlink_to(root / "ring.png")
    os.mkfifo(root / "pipe.png")
    found = folder(root)
    assert [item.name for item in found.items] == ["inside"]
    reasons = {"leak": "outside", "within": "duplicate", "broken": "unreadable", "ring": "unreadable"}
    assert {row.name: row.reason for row in found.rejected} == reasons
    assert found.ignored == 1  # the pipe, which would be waited for


def test_a_picture_that_may_not_be_read_is_rejected(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    picture(tmp_path / "open-1.png", 9)
    locked = picture(tmp_path / "locked-1.png", 7)
    opened = Path.open

    def refuse(path: Path, *arguments: Any, **options: Any) -> Any:
        if path == locked:  # root may read everything, so that modes would test nothing
            raise PermissionError(13, "Permission denied", str(path))
        return opened(path, *arguments, **options)

    monkeypatch.setattr(Path, "open", refuse)
    found = folder(tmp_path)
    assert [item.name for item in found.items] == ["open-1"]
    assert [(row.name, row.reason) for row in found.rejected] == [("locked-1", "unreadable")]
    assert "Permission denied" in found.rejected[0].message


def test_nothing_there(tmp_path: Path) -> None:
    with pytest.raises(DatasetError, match="no pictures"):
        folder(tmp_path)
    with pytest.raises(DatasetError, match="does not exist"):
        folder(tmp_path / "missing")
    with pytest.raises(DatasetError, match="not a folder"):
        folder(picture(tmp_path / "file.png"))
    with pytest.raises(DatasetError, match=r"dataset\.root=DIR"):
        collect(DatasetConfig("mine", "folder"))
    with pytest.raises(FileNotFoundError, match=r"pipeline\.fetch mpeg7"):
        collect(DatasetConfig("m", "mpeg7", root=str(tmp_path / "missing")))
    with pytest.raises(RiotError, match="20 sub-folders"):
        collect(DatasetConfig("a", "animals", root=str(tmp_path / "missing")))
    with pytest.raises(ValueError, match="limit"):
        DatasetConfig(limit=0)
    with pytest.raises(ValueError, match="folder of the outputs"):
        DatasetConfig("../elsewhere")
    with pytest.raises(ValueError, match=r"root: expected a folder"):
        DatasetConfig("mine", "folder", root="")
    with pytest.raises(ValueError, match=r"sample has dataset\.name, dataset\.limit only.*\+dataset=folder"):
        DatasetConfig(root="mine")


def test_default_root(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(datasets, "user_cache_path", lambda name: tmp_path / name)
    picture(tmp_path / "riot" / "mpeg7" / "original" / "bell-3.png")
    (item,) = collect(DatasetConfig("mpeg7", "mpeg7")).items
    assert (item.name, item.cls) == ("original/bell-3", "bell")  # the archive's folder is no class


def test_paper_joins_both_sets(tmp_path: Path) -> None:
    picture(tmp_path / "mpeg7" / "bird-1.png", 10)
    picture(tmp_path / "animals" / "Bird" / "7.png", 11)
    picture(tmp_path / "animals" / "Cow" / "8.png", 10)  # the same bytes as mpeg7's bird
    found = collect(DatasetConfig("paper", "paper", root=str(tmp_path)))
    assert [(item.name, item.cls) for item in found.items] == [("animals/Bird/7", "bird"), ("animals/Cow/8", "cow")]
    assert [row.name for row in found.rejected] == ["mpeg7/bird-1"]
    apart = DatasetConfig("paper", "paper", mpeg7=str(tmp_path / "mpeg7"), animals=str(tmp_path / "animals"))
    assert collect(apart) == found
    with pytest.raises(DatasetError, match=r"dataset\.animals=DIR"):
        collect(DatasetConfig("paper", "paper", mpeg7=str(tmp_path / "mpeg7"), animals=str(tmp_path / "none")))


def test_limit_spreads_evenly(tmp_path: Path) -> None:
    for k in range(10):
        picture(tmp_path / f"p{k}.png", 10 + k)
    assert [item.name for item in folder(tmp_path, limit=5).items] == ["p0", "p2", "p4", "p6", "p8"]
    assert len(folder(tmp_path, limit=99).items) == 10


def test_sample_is_a_collection() -> None:
    items = collect(DatasetConfig()).items
    names = [item.name for item in items]
    assert 90 <= len(items) <= 110
    assert names == sorted(names)
    assert len(set(names)) == len({item.digest for item in items}) == len(items)
    pairs = [item for item in items if item.name.startswith("pair")]
    assert len(pairs) == 8
    assert len({item.cls for item in pairs}) == 8  # a partner is never of the same class
    assert {"chess", "card", "tool"} <= {item.cls for item in items}


def test_every_shape_of_the_sample() -> None:
    for item in collect(DatasetConfig()).items:
        shape = open_item(item)
        assert shape.name == item.name
        assert is_simple(shape.points)
        assert len(shape.points) >= 100


def test_sample_is_the_same_in_every_process() -> None:
    code = (
        "from pipeline.datasets import sample; print(hash(str(sample.definitions())) * 0, sample.definitions()[7:90:9])"
    )
    runs = [
        subprocess.run(
            [sys.executable, "-c", code], check=True, capture_output=True, text=True, env={"PYTHONHASHSEED": seed}
        ).stdout
        for seed in ("1", "2")
    ]
    assert runs[0] == runs[1]
    assert repr(sample.definitions()[7]) in runs[0]


def test_unknown_sample() -> None:
    with pytest.raises(SilhouetteError, match="no such shape"):
        sample.shape("sample:nothing")


def test_names_that_are_no_text_are_rejected(tmp_path: Path) -> None:
    """Linux takes any bytes for a name; tables and keys take text."""
    whole = picture(tmp_path / "good-1.png")
    (tmp_path / os.fsdecode(b"bad\xff-1.png")).write_bytes(whole.read_bytes() + b"x")
    found = folder(tmp_path)
    assert [item.name for item in found.items] == ["good-1"]
    assert [(row.name, row.reason) for row in found.rejected] == [("bad\\udcff-1", "name")]
    (row,) = found.rejected
    assert "rename" in row.message and (row.message + row.source + row.name).isascii()


def test_an_inner_suffix_hides_no_class() -> None:
    assert [class_of(name) for name in ("obj10_1.pgm", "obj10__7", "cat.v2_3", "a-1-2", "7")] == [
        "obj10",
        "obj10",
        "cat.v2",
        "a-1",
        "",
    ]


def test_the_home_folder_may_be_a_tilde(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    folder = tmp_path / "pics"
    folder.mkdir()
    (folder / "a.png").write_bytes(b"a")
    found = collect(DatasetConfig(name="pics", kind="folder", root="~/pics"))
    assert [item.source for item in found.items] == [str(folder / "a.png")]

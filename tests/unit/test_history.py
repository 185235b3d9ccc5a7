"""Where a transform comes from: told by its file, the same for the same input, without a place or a time."""

from __future__ import annotations

import hashlib
import json
from dataclasses import replace
from pathlib import Path

import pytest
from PIL import Image, ImageDraw

from riot import Transform
from riot.cli.main import main
from riot.errors import FormatError
from riot.groundtruth.pairs import exact_pair, exact_transform
from riot.transform.history import History, HistoryStep
from riot.transform.provenance import code_digest, describe_history, record_history
from riot.transform.riot_file import add_history, from_json, to_json

HISTORY = History(
    "riot make",
    ("a" * 64, "b" * 64),
    (HistoryStep("ingest", {"spacing": 100.0, "deep": {"list": [1, None, "é"]}}, "c" * 64, ("d" * 64, "e" * 64)),),
    {"numpy": "2.0"},
)


def test_a_history_reads_back_equal_and_changes_nothing_else() -> None:
    transform = exact_transform(exact_pair(4, 1))
    text = to_json(replace(transform, history=HISTORY))
    again = from_json(text)
    assert again.history == HISTORY and to_json(again) == text
    assert to_json(replace(again, history=None)) == to_json(transform)
    assert from_json(to_json(transform)).history is None
    assert add_history(to_json(transform), HISTORY) == text


@pytest.mark.parametrize("field", ["maker", "pictures", "steps", "versions"])
@pytest.mark.parametrize("value", [None, 5, ["a"], [5, 5], [{"name": 5}], {"name": 5}])
def test_a_damaged_history_is_refused(field: str, value: object) -> None:
    document = json.loads(to_json(replace(exact_transform(exact_pair(3, 1)), history=HISTORY)))
    document["history"][field] = value
    with pytest.raises(FormatError, match="damaged"):
        from_json(json.dumps(document))


def test_it_is_told_line_by_line() -> None:
    assert list(describe_history(HISTORY)) == [
        "made by: riot make",
        f"picture P: sha256 {'a' * 64}",
        f"picture Q: sha256 {'b' * 64}",
        f"ingest: code {'c' * 64}",
        f"  key {'d' * 64}",
        f"  key {'e' * 64}",
        "  spacing = 100.0",
        "  deep.list = [1, None, 'é']",
        "libraries: numpy 2.0",
    ]


def test_code_is_digested_by_name_and_content(tmp_path: Path) -> None:
    for folder in ("one", "two", "three"):
        (tmp_path / folder / "inner").mkdir(parents=True)
        (tmp_path / folder / "inner" / "a.py").write_text("x = 1\n")
        (tmp_path / folder / "notes.txt").write_text(folder)
    (tmp_path / "three" / "inner" / "a.py").rename(tmp_path / "three" / "a.py")
    first, second, third = (code_digest(tmp_path / folder) for folder in ("one", "two", "three"))
    assert first == second != third
    (tmp_path / "two" / "inner" / "a.py").write_text("x = 2\n")
    assert code_digest(tmp_path / "two") != first


def drawn(path: Path, corners: list[tuple[float, float]]) -> Path:
    path.parent.mkdir(exist_ok=True)
    image = Image.new("L", (240, 240))
    ImageDraw.Draw(image).polygon(corners, 255)
    image.save(path)
    return path


def test_made_twice_in_two_places_the_file_is_the_same_and_tells(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    files = []
    for folder in ("here", "there"):
        house = drawn(tmp_path / folder / "house.png", [(40, 210), (40, 110), (120, 30), (200, 110), (200, 210)])
        kite = drawn(tmp_path / folder / "kite.png", [(120, 20), (210, 110), (120, 225), (40, 110)])
        assert main(["make", str(house), str(kite), "-o", str(tmp_path / folder)]) == 0
        files.append(tmp_path / folder / "house--kite.riot")
    assert files[0].read_bytes() == files[1].read_bytes()
    assert str(tmp_path).encode() not in files[0].read_bytes()
    capsys.readouterr()
    assert main(["show", str(files[0]), "--history"]) == 0
    output = capsys.readouterr().out
    for picture in (house, kite):
        assert hashlib.sha256(picture.read_bytes()).hexdigest() in output
    for words in ("made by: riot make", "construct: code ", "  method = exact", "  tau_s = 0.1", "numba "):
        assert words in output
    history = Transform.load(files[0]).history
    assert history is not None and history == record_history(
        "riot make", (house, kite), {step.name: step.parameters for step in history.steps}
    )


def test_a_file_without_a_history_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "old.riot"
    exact_transform(exact_pair(3, 1)).save(path)
    assert main(["show", str(path), "--history"]) == 0
    assert "no history" in capsys.readouterr().out

"""The quiz: its halves, its page as a parser sees it, and its refusals. Its shapes are those of exact pairs."""

from __future__ import annotations

from html.parser import HTMLParser
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from given_run import GivenRun, given_run
from hypothesis import given
from hypothesis import strategies as st

from pipeline.errors import StartError
from pipeline.study.findings import write_findings
from pipeline.study.quiz import QUIZ, Parameters, right_answers, study, with_hindsight
from pipeline.study.quiz_pairs import QuizPair
from riot import Shape
from riot.errors import ParameterError
from riot.groundtruth.pairs import exact_pair, exact_transform
from riot.transform.riot_file import to_json

EXACT, FOUND = 7, 4
"""Exact pairs, whose shapes are 2k and 2k + 1, and how many of them, the first, the run has transforms of."""

OURS = Parameters(pairs=4, margin=0.02)
VOID = {"meta", "link", "input", "img", "br", "path", "use", "rect", "circle"}


@pytest.fixture(scope="module")
def quiz_run(tmp_path_factory: pytest.TempPathFactory) -> GivenRun:
    """A run with what the quiz reads of it."""
    folder = tmp_path_factory.mktemp("exact")
    exact = [exact_pair(3 + k % 2, 40 + k, curved=False, topology="star") for k in range(EXACT)]
    run = given_run(folder, [Shape.from_polygon(outline) for pair in exact for outline in (pair.p, pair.q)], EXACT)
    (folder / "transforms").mkdir()
    (folder / "qcrs").mkdir()
    rows: list[dict[str, Any]] = []
    for k, pair in enumerate(exact[:FOUND]):
        file = f"transforms/{k}.riot"
        (folder / file).write_text(to_json(exact_transform(pair)), encoding="utf-8")
        rows.append(
            {"i": 2 * k, "j": 2 * k + 1, "class_i": run.classes[2 * k], "class_j": run.classes[2 * k + 1],
             "chosen": True, "status": "certified", "iou": 0.999 - 0.001 * k, "qcrs": 0.95, "crs": 0.9, "file": file}
        )  # fmt: skip
    pq.write_table(pa.Table.from_pylist(rows), folder / "transforms.parquet")
    i, j = (column.astype(np.int32) for column in np.triu_indices(2 * EXACT, 1))
    quick = np.random.default_rng(5).random(len(i))
    pq.write_table(pa.table({"i": i, "j": j, "score": quick}), folder / "qcrs" / "part.parquet")
    return run


def files(quiz_run: GivenRun, parameters: Parameters) -> dict[str, bytes]:
    """Every file of the study."""
    folder = quiz_run.mined.folder / "study" / "quiz"
    write_findings(study(quiz_run, parameters, lambda _: None), folder)
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.fixture(scope="module")
def asked(quiz_run: GivenRun) -> dict[str, bytes]:
    return files(quiz_run, OURS)


def rows_of(written: dict[str, bytes]) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = pq.read_table(pa.BufferReader(written["table.parquet"])).to_pylist()
    return rows


class Page(HTMLParser):
    """Elements in order, each with its attributes, its text, and whether it is among the answers."""

    def __init__(self, content: bytes) -> None:
        super().__init__()
        self.found: list[dict[str, str]] = []
        self._open: list[dict[str, str]] = []
        self.feed(content.decode())
        self.close()
        assert not self._open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        within = any(element.get("id") == "answers" for element in self._open)
        element = {
            "tag": tag,
            "text": "",
            "answers": "yes" if within else "",
            **{name: value or "" for name, value in attrs},
        }
        self.found.append(element)
        if tag not in VOID:
            self._open.append(element)

    def handle_endtag(self, tag: str) -> None:
        if tag not in VOID:
            assert self._open.pop()["tag"] == tag

    def handle_data(self, data: str) -> None:
        for element in self._open:
            element["text"] += data

    def of(self, tag: str, **attributes: str) -> list[dict[str, str]]:
        return [
            element
            for element in self.found
            if element["tag"] == tag and all(element.get(k) == v for k, v in attributes.items())
        ]


def test_one_half_are_transforms_and_the_other_falls_short_of_them_all(
    quiz_run: GivenRun, asked: dict[str, bytes]
) -> None:
    rows = rows_of(asked)
    yes, no = ([row for row in rows if row["reversible"] == which] for which in (True, False))
    assert len(yes) == len(no) == OURS.pairs // 2
    shapes = [row[side] for row in rows for side in ("left", "right")]
    assert len(set(shapes)) == len(shapes)
    assert all({row["left"] // 2, row["right"] // 2} == {row["left"] // 2} and row["left"] < 2 * FOUND for row in yes)
    assert all(row["file"] for row in yes) and not any(row["file"] for row in no)
    assert max(row["iou"] for row in no) <= min(row["iou"] for row in yes) - OURS.margin
    for row in no:
        pair = np.array([sorted((row["left"], row["right"]))])
        assert row["qcrs"] == quiz_run.quick_scores(pair)[0]
        assert row["class_left"] != row["class_right"]


def test_the_same_seed_gives_the_same_bytes_and_another_other_pairs(
    quiz_run: GivenRun, asked: dict[str, bytes]
) -> None:
    assert files(quiz_run, OURS) == asked
    other_rows = rows_of(files(quiz_run, Parameters(pairs=4, margin=0.02, seed=7)))
    assert [(row["left"], row["right"]) for row in other_rows] != [
        (row["left"], row["right"]) for row in rows_of(asked)
    ]


def test_the_page_asks_for_every_pair_of_the_table_and_answers_it(asked: dict[str, bytes]) -> None:
    page, rows = Page(asked[QUIZ]), rows_of(asked)
    sets = page.of("fieldset")
    assert [element["data-right"] for element in sets] == ["yes" if row["reversible"] else "no" for row in rows]
    assert [element["text"] for element in page.of("legend")] == [f"Pair {row['pair']}" for row in rows]
    for row in rows:
        assert [element["value"] for element in page.of("input", type="radio", name=f"pair{row['pair']}")] == [
            "yes",
            "no",
        ]
    answers = [element["text"] for element in page.of("tr", answers="yes")][1:]
    for row, answer in zip(rows, answers, strict=True):
        assert answer.startswith(f"{row['pair']}{row['name_left']}, {row['name_right']}")
        assert ("reversible" in answer) == row["reversible"]
    descriptions = [element["alt"] for element in page.of("img", answers="yes")]
    assert len(descriptions) == OURS.pairs // 2
    for alt, row in zip(descriptions, (row for row in rows if row["reversible"]), strict=True):
        assert row["name_left"] in alt and row["name_right"] in alt


def test_every_picture_has_words_and_none_of_a_question_names_its_shape(asked: dict[str, bytes]) -> None:
    page = Page(asked[QUIZ])
    pictures = page.of("svg", role="img")
    assert len(pictures) == 2 * OURS.pairs == len(page.of("title")) - 1
    words = [picture["text"] for picture in pictures]
    assert len(set(words)) == len(words) and all("class&" in description for description in words)
    before = "".join(picture["text"] for picture in page.found if picture["tag"] in ("form", "header"))
    assert "Pair 1" in before and "class&" in before
    assert not any(row[side] in before for row in rows_of(asked) for side in ("name_left", "name_right"))
    assert all(picture["alt"] for picture in page.of("img"))


def test_the_page_needs_no_other_file_and_hides_what_only_its_script_can_do(asked: dict[str, bytes]) -> None:
    page = Page(asked[QUIZ])
    for element in page.found:
        for name in ("src", "href"):
            assert element.get(name, "#").startswith(("#", "data:"))
    assert [element["href"] for element in page.of("a")] == ["#answers"]
    bar = page.of("div", **{"class": "score"})
    assert (
        len(bar) == 1
        and "hidden" in bar[0]
        and all("hidden" in element for element in page.of("p", **{"class": "verdict"}))
    )
    ids = [element["id"] for element in page.found if "id" in element]
    assert len(set(ids)) == len(ids)


@given(st.lists(st.tuples(st.booleans(), st.floats(0.0, 1.0)), min_size=1, max_size=16), st.floats(-0.5, 1.5))
def test_no_threshold_is_better_than_hindsight(answers: list[tuple[bool, float]], threshold: float) -> None:
    pairs = [QuizPair(0, 1, which, 0.0, 0.0, 0.0) for which, _ in answers]
    scores = [score for _, score in answers]
    best = with_hindsight(pairs, scores)
    assert right_answers(pairs, scores, threshold) <= best
    most = max(sum(which for which, _ in answers), sum(not which for which, _ in answers))
    assert most <= best <= len(pairs)
    # A score that is above the threshold exactly where the pair is reversible is always right.
    assert right_answers(pairs, [threshold + (0.1 if pair.reversible else -0.1) for pair in pairs], threshold) == len(
        pairs
    )


def test_refusals_say_what_to_do(quiz_run: GivenRun) -> None:
    for values, words in (({"pairs": 3}, "even"), ({"margin": 2.0}, "margin"), ({"seed": -1}, "seed")):
        with pytest.raises(ParameterError, match=words):
            Parameters(**values)
    with pytest.raises(StartError, match=f"give pairs={2 * FOUND}"):
        study(quiz_run, Parameters(pairs=16), lambda _: None)
    with pytest.raises(StartError, match="a smaller margin"):
        study(quiz_run, Parameters(pairs=4, margin=1.0), lambda _: None)
    (gone := quiz_run.mined.folder / "transforms").rename(quiz_run.mined.folder / "elsewhere")
    with pytest.raises(StartError, match="run the pipeline again"):
        study(quiz_run, OURS, lambda _: None)
    (quiz_run.mined.folder / "elsewhere").rename(gone)

"""The quiz as one page: questions to click or to print, and the answers, which print on a sheet of their own. Ours.

Without its script the page is a form to fill in, and a link shows the answers.
"""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.report.markup import document, number, section, table
from pipeline.report.thumb import HEIGHT, WIDTH, thumb
from pipeline.study.finished import Finished
from pipeline.study.quiz_pairs import Pair
from pipeline.study.quiz_style import SCRIPT_TEXT, quiz_style
from riot.draw.panels import DETAIL
from riot.draw.scene import Region, Scene
from riot.draw.svg import escape, fragment
from riot.geometry.polyline import simplify
from riot.transform.transform import Transform
from riot.types import FloatArray

MARGIN = 0.04
"""Around a silhouette, in units of √area."""


@dataclass(frozen=True)
class Answers:
    """How many pairs each score is right about, which says "reversible" above ``threshold``.

    ``people``: how many judged pairs in the paper, and the share of their answers that was right.
    """

    right: Sequence[tuple[str, int]]
    threshold: float
    people: tuple[int, float]


def quiz_page(
    finished: Finished,
    pairs: Sequence[Pair],
    transforms: Mapping[str, Transform],
    reversible: FloatArray,
    answers: Answers,
) -> str:
    """The whole page; ``transforms`` by file, ``reversible`` S_r by shape number. The same input gives the same text.

    Up to the answers it names no shape, and says nothing that tells the halves apart to whoever looks at it.
    """
    questions = "".join(_question(finished, place, pair) for place, pair in enumerate(pairs, 1))
    half = len(pairs) // 2
    body = (
        f'<header class="top"><p class="kicker">Quiz · {escape(finished.mined.dataset)}</p>'
        "<h1>Which pairs are reversible?</h1>"
        '<p class="lead">Two shapes are reversible if one can be cut into pieces, hinged in a chain, that swing round '
        f"to make the other. {half} of these {len(pairs)} pairs are, after changes that are hard to see; the other "
        f"{half} change much more by the best way found. Which are which?</p></header>\n"
        f'<main><form class="quiz" autocomplete="off"><ol class="questions">\n{questions}</ol>'
        f"{_score(len(pairs), answers)}</form>\n"
        '<p class="reveal"><a href="#answers">Show the answers</a></p>\n'
        f"{_answers(finished, pairs, transforms, reversible, answers)}</main>\n"
        f"<script>{SCRIPT_TEXT}</script>"
    )
    return document("Which pairs are reversible?", f"<style>{quiz_style()}</style>", body)


def _question(finished: Finished, place: int, pair: Pair) -> str:
    outlines = [finished.shapes[number].points for number in (pair.left, pair.right)]
    centred = [points - (points.min(axis=0) + points.max(axis=0)) / 2.0 for points in outlines]
    # One scale for both: their areas are equal, and are to look it.
    half = max(float(np.abs(points).max()) for points in centred) + MARGIN
    pictures = "".join(
        fragment(_silhouette(points, f"Pair {place}, {side}: {_kind(finished, shape)}", half), "")
        for points, side, shape in zip(centred, ("left", "right"), (pair.left, pair.right), strict=True)
    )
    choices = "".join(
        f'<label><input type="radio" name="pair{place}" value="{value}"> {words}</label>'
        for value, words in (("yes", "reversible"), ("no", "not"))
    )
    right = "yes" if pair.reversible else "no"
    return (
        f'<li><fieldset data-right="{right}"><legend>Pair {place}</legend><div class="two">{pictures}</div>'
        f'<div class="choices">{choices}</div><p class="verdict" hidden></p></fieldset></li>\n'
    )


def _silhouette(points: FloatArray, title: str, half: float) -> Scene:
    drawn = points[simplify(points, DETAIL)]
    return Scene(title, (-half, -half, half, half), half / 60.0, (), (Region((drawn,), "silhouette"),))


def _kind(finished: Finished, shape: int) -> str:
    """What stands for a silhouette to those who cannot see it."""
    return f"silhouette of class {cls}" if (cls := finished.classes[shape]) else "silhouette without a class"


def _score(count: int, answers: Answers) -> str:
    """What the script shows and fills in; hidden until then."""
    return (
        f'<div class="score" hidden><output role="status" data-beside="{escape(_beside(count, answers))}"></output>'
        '<button type="submit">Score</button><button type="reset">Start again</button>'
        '<p class="keys"><kbd>Y</kbd> reversible, <kbd>N</kbd> not, and on to the next</p></div>'
    )


def _beside(count: int, answers: Answers) -> str:
    scores = ", ".join(f"{name} {right}" for name, right in answers.right)
    people, share = answers.people
    return f"Right of these {count}: {scores}. The paper's {people} participants: {share:.0%} of 16."


def _answers(
    finished: Finished,
    pairs: Sequence[Pair],
    transforms: Mapping[str, Transform],
    reversible: FloatArray,
    answers: Answers,
) -> str:
    names = finished.mined.names
    rows = [
        [
            str(place),
            escape(f"{names[pair.left]}, {names[pair.right]}"),
            "<b>reversible</b>" if pair.reversible else "not",
            f"{'' if pair.reversible else '≤ '}{number(pair.worth)}",
            f"{number(float(reversible[pair.left]), 2)}, {number(float(reversible[pair.right]), 2)}",
            number(pair.quick, 2),
            number(pair.cross, 2),
        ]
        for place, pair in enumerate(pairs, 1)
    ]
    head = ["pair", "shapes", "answer", "IoU", "S<sub>r</sub>", "QCRS", "CRS"]
    sheet = table(head, rows, [False, False, False, True, True, True, True], "The right answers")
    note = (
        "IoU: how much of the worse shape stays as it was when the pair is made exactly reversible; of the others, "
        f"the most that the best trunks found allow. QCRS and CRS say reversible above {answers.threshold:g}. "
        "They helped to find the pairs of both halves, so this is no test of them. Not reversible means: not by the "
        "trunks that the search looks at. Dudeney's triangle and square are reversible by another, which has an empty "
        "exterior piece. "
    )
    made = "".join(
        _made(place, pair, transforms[pair.file], names) for place, pair in enumerate(pairs, 1) if pair.reversible
    )
    body = f'<div class="sheet">{sheet}</div><div class="made">{made}</div>'
    return section("answers", "Answers", body, note + _beside(len(pairs), answers))


def _made(place: int, pair: Pair, transform: Transform, names: Sequence[str]) -> str:
    data = base64.b64encode(thumb(transform).encode()).decode()
    # A transform's P is the shape of the lower number, on whichever side the quiz shows it.
    p, q = sorted((pair.left, pair.right))
    said = f"Pair {place}: {names[p]} and {names[q]}, each of the same {len(transform)} pieces"
    return (
        f'<figure><img alt="{escape(said)}" width="{WIDTH}" height="{HEIGHT}" '
        f'src="data:image/svg+xml;base64,{data}"><figcaption>pair {place}</figcaption></figure>'
    )

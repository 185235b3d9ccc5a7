"""The quiz as one page: questions to click or to print, and the answers, which print on a sheet of their own. Ours.

Without its script the page is a form to fill in, and a link shows the answers.
"""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.report.environment import render
from pipeline.report.pictures import HEIGHT, WIDTH, thumb
from pipeline.study.finished import StudiedRun
from pipeline.study.quiz_pairs import QuizPair
from riot.draw.palette import LIGHT
from riot.draw.scene import Region, Scene
from riot.draw.svg import fragment
from riot.draw.svg_style import page_colours
from riot.draw.tuning import SKETCH_TOLERANCE
from riot.errors import needs_extra
from riot.geometry.polyline import simplify
from riot.transform.transform import Transform
from riot.types import FloatArray

with needs_extra("mine"):
    from markupsafe import Markup

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


@dataclass(frozen=True)
class Question:
    """A pair as the page asks for it and answers it.

    ``silhouettes`` are SVG elements, ``reversibilities`` S_r of both shapes; ``transform`` is a picture of both
    dissections, an SVG file in base64, with its description, None unless the pair is reversible.
    """

    number: int
    pair: QuizPair
    silhouettes: tuple[Markup, Markup]
    names: tuple[str, str]
    reversibilities: tuple[float, float]
    transform: tuple[str, str] | None


def quiz_page(
    finished: StudiedRun,
    pairs: Sequence[QuizPair],
    transforms: Mapping[str, Transform],
    reversible: FloatArray,
    answers: Answers,
) -> str:
    """The whole page; ``transforms`` by file, ``reversible`` S_r by shape number. The same input gives the same text.

    Up to the answers it names no shape, and says nothing that tells the halves apart to whoever looks at it.
    """
    names = finished.mined.names
    questions = [
        Question(
            number,
            pair,
            _silhouettes(finished, number, pair),
            (names[pair.left], names[pair.right]),
            (float(reversible[pair.left]), float(reversible[pair.right])),
            _transform(number, pair, transforms[pair.file], names) if pair.reversible else None,
        )
        for number, pair in enumerate(pairs, 1)
    ]
    return render(
        "quiz.html",
        dataset=finished.mined.dataset,
        questions=questions,
        answers=answers,
        size=(WIDTH, HEIGHT),
        paper_colours=Markup(page_colours(LIGHT)),
    )


def _silhouettes(finished: StudiedRun, number: int, pair: QuizPair) -> tuple[Markup, Markup]:
    outlines = [finished.shapes[shape].points for shape in (pair.left, pair.right)]
    centred = [points - (points.min(axis=0) + points.max(axis=0)) / 2.0 for points in outlines]
    # One scale for both: their areas are equal, and are to look it.
    half = max(float(np.abs(points).max()) for points in centred) + MARGIN
    titles = [
        f"Pair {number}, {side}: {_kind(finished, shape)}"
        for side, shape in (("left", pair.left), ("right", pair.right))
    ]
    left, right = (_silhouette(points, title, half) for points, title in zip(centred, titles, strict=True))
    return left, right


def _silhouette(points: FloatArray, title: str, half: float) -> Markup:
    drawn = points[simplify(points, SKETCH_TOLERANCE)]
    scene = Scene(title, (-half, -half, half, half), half / 60.0, (), (Region((drawn,), "silhouette"),))
    return Markup(fragment(scene, ""))


def _kind(finished: StudiedRun, shape: int) -> str:
    """What stands for a silhouette to those who cannot see it."""
    return f"silhouette of class {cls}" if (cls := finished.classes[shape]) else "silhouette without a class"


def _transform(number: int, pair: QuizPair, transform: Transform, names: Sequence[str]) -> tuple[str, str]:
    # A transform's P is the shape of the lower number, on whichever side the quiz shows it.
    p, q = sorted((pair.left, pair.right))
    words = f"Pair {number}: {names[p]} and {names[q]}, each of the same {len(transform)} pieces"
    return base64.b64encode(thumb(transform).encode()).decode(), words

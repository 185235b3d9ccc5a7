"""The paper's human study (§6) as a sheet of pairs to judge, and what the scores answer."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from matplotlib.figure import Figure

from pipeline.errors import StartError
from pipeline.study import plots
from pipeline.study.findings import Findings, Sheet, of_columns
from pipeline.study.finished import StudiedRun
from pipeline.study.partners import StudiedPartners
from pipeline.study.quiz_page import Answers, quiz_page
from pipeline.study.quiz_pairs import QuizPair, choose
from pipeline.tables.schemas import column
from riot.draw.palette import LIGHT, PIECES
from riot.errors import FormatError, ParameterError, needs_extra
from riot.parameters.field import ParameterGroup, parameter
from riot.transform.riot_file import from_json
from riot.transform.transform import Transform
from riot.types import FloatArray

with needs_extra("mine"):
    import pyarrow as pa

QUIZ = "quiz.html"

PEOPLE, RIGHT = 30, 0.41
"""How many people judged 16 pairs in the paper, and which share of their answers was right."""

HALVES = {True: "reversible", False: "not reversible"}


@dataclass(frozen=True)
class Parameters(ParameterGroup):
    """Which pairs are shown, and when a score says that a pair is reversible."""

    pairs: int = parameter(16, at_least=2, meaning="Pairs that are shown, half of them reversible.")
    margin: float = parameter(
        0.05,
        at_least=0,
        at_most=1,
        meaning="Refined trunks of the other half allow an IoU that is so far below the least of the reversible ones.",
    )
    threshold: float = parameter(
        0.5,
        at_least=0,
        at_most=1,
        source="paper §6",
        meaning="A score above this says reversible; the paper constructs pairs of greater CRS.",
    )
    seed: int = parameter(2018, at_least=0, meaning="Seed of the choice of pairs.")

    def check_together(self) -> None:
        """Check that the pairs can be halved; raises `riot.errors.ParameterError`."""
        if self.pairs % 2:
            raise ParameterError("pairs", f"must be even, got {self.pairs}")


def study(finished: StudiedRun, parameters: Parameters, say: Callable[[str], None]) -> Findings:
    """Choose the pairs, let the scores answer, and make the sheet, `QUIZ`, that goes beside the study's page."""
    say(f"choosing {parameters.pairs} pairs …")
    partners = StudiedPartners(finished.shapes, finished.config.trunks, finished.config.refine, finished.config.crs)
    pairs = choose(finished, partners, parameters.pairs, parameters.margin, np.random.default_rng(parameters.seed))
    reversible = finished.values("reversibility", "score")
    answers = Answers(
        [
            ("QCRS", right_answers(pairs, [pair.quick for pair in pairs], parameters.threshold)),
            ("CRS", right_answers(pairs, [pair.cross for pair in pairs], parameters.threshold)),
        ],
        parameters.threshold,
        (PEOPLE, RIGHT),
    )
    transforms = {pair.file: _transform(finished, pair.file) for pair in pairs if pair.file}
    page = quiz_page(finished, pairs, transforms, reversible, answers)
    findings = _findings(finished, parameters, pairs, reversible, answers)
    return replace(findings, files={QUIZ: page.encode()})


def right_answers(pairs: Sequence[QuizPair], scores: Sequence[float], threshold: float) -> int:
    """How many pairs a score is right about that calls those above ``threshold`` reversible."""
    return sum((score > threshold) == pair.reversible for pair, score in zip(pairs, scores, strict=True))


def with_hindsight(pairs: Sequence[QuizPair], scores: Sequence[float]) -> int:
    """The greatest number of `right_answers` that any threshold gives."""
    return max(right_answers(pairs, scores, threshold) for threshold in (-1.0, *scores))


def _transform(finished: StudiedRun, file: str) -> Transform:
    path = finished.mined.folder / file
    try:
        return from_json(path.read_text(encoding="utf-8"), str(path))
    except (OSError, FormatError) as error:
        raise StartError(f"{path}: gone or damaged; run the pipeline again to restore it ({error})") from error


def _findings(
    finished: StudiedRun, parameters: Parameters, pairs: Sequence[QuizPair], reversible: FloatArray, answers: Answers
) -> Findings:
    count = len(pairs)
    scores = {"QCRS": [pair.quick for pair in pairs], "CRS": [pair.cross for pair in pairs]}
    judges = [
        (f"people, the paper's pairs (mean of {PEOPLE})", f"{RIGHT:.0%}", "–"),
        *(
            (name, f"{right} of {count} ({right / count:.0%})", f"{with_hindsight(pairs, scores[name])} of {count}")
            for name, right in answers.right
        ),
    ]
    scores_right = ", ".join(f"{name} {right}" for name, right in answers.right)
    return Findings(
        f"Quiz of {finished.mined.dataset}",
        f"{QUIZ} beside this page shows {count} pairs to judge. The paper's {PEOPLE} participants had {RIGHT:.0%} of "
        f"theirs right; of these, above {parameters.threshold:g} = reversible, {scores_right} of {count}. The run had "
        "found its transforms by the same scores, and low QCRS was sought in the other half: this is no test of the "
        "scores, but a measure of what people are up against.",
        _table(finished, pairs, reversible, parameters.threshold),
        [
            Sheet("Right answers", ("who", "right", "with the best threshold in hindsight"), judges),
            Sheet("The halves", ("half", "pairs", "IoU", "QCRS", "CRS", "lower S_r", "higher S_r"),
                  [_half(pairs, reversible, which) for which in HALVES]),
        ],
        {
            "scores": (_scatter(pairs, scores["QCRS"], scores["CRS"], "QCRS", "CRS", parameters.threshold),
                       "What the scores give the pairs of either half; lines = the threshold"),
            "reversibility": (_scatter(pairs, *_reversibilities(pairs, reversible), "lower S_r", "higher S_r"),
                              "S_r of the two shapes of every pair: it does not give the halves away"),
        },
    )  # fmt: skip


def _reversibilities(pairs: Sequence[QuizPair], reversible: FloatArray) -> tuple[list[float], list[float]]:
    both = np.sort(reversible[[(pair.left, pair.right) for pair in pairs]], axis=1)
    return both[:, 0].tolist(), both[:, 1].tolist()


def _half(pairs: Sequence[QuizPair], reversible: FloatArray, which: bool) -> tuple[str, ...]:
    """Range of what is known of one half."""
    half = [pair for pair in pairs if pair.reversible == which]
    known = ([pair.worth for pair in half], [pair.quick for pair in half], [pair.cross for pair in half],
             *_reversibilities(half, reversible))  # fmt: skip
    return HALVES[which], str(len(half)), *(f"{min(values):.3f} – {max(values):.3f}" for values in known)


def _scatter(
    pairs: Sequence[QuizPair],
    x: Sequence[float],
    y: Sequence[float],
    x_name: str,
    y_name: str,
    line: float | None = None,
) -> Figure:
    """The pairs of either half by two scores in [0, 1]."""
    figure, plot = plots.axes(x_name, y_name)
    marks: Mapping[bool, tuple[str, str]] = {True: ("o", PIECES[0]), False: ("X", PIECES[2])}
    for which, name in HALVES.items():
        half = [k for k, pair in enumerate(pairs) if pair.reversible == which]
        mark, colour = marks[which]
        plot.scatter([x[k] for k in half], [y[k] for k in half], 42, color=colour, marker=mark, label=name, alpha=0.85)
    if line is not None:
        plot.axvline(line, color=LIGHT["muted"], linewidth=0.8, linestyle=":")
        plot.axhline(line, color=LIGHT["muted"], linewidth=0.8, linestyle=":")
    plot.set_xlim(-0.02, 1.02)
    plot.set_ylim(-0.02, 1.02)
    plot.legend(frameon=False, loc="lower left" if line is None else "upper left")
    return figure


def _table(finished: StudiedRun, pairs: Sequence[QuizPair], reversible: FloatArray, threshold: float) -> pa.Table:
    names, classes = finished.mined.names, finished.classes
    left, right = [pair.left for pair in pairs], [pair.right for pair in pairs]
    unit = "score in [0, 1]"
    return of_columns(
        "The pairs of the quiz, as they are numbered there.",
        [
            (column("pair", pa.int32(), "number of the pair in the quiz, from 1"), range(1, len(pairs) + 1)),
            (column("left", pa.int32(), "shape on the left", "shape number"), left),
            (column("right", pa.int32(), "shape on the right", "shape number"), right),
            (column("name_left", pa.string(), "name of the shape on the left"), [names[k] for k in left]),
            (column("name_right", pa.string(), "name of the shape on the right"), [names[k] for k in right]),
            (column("class_left", pa.string(), "its class, empty = none"), [classes[k] for k in left]),
            (column("class_right", pa.string(), "its class, empty = none"), [classes[k] for k in right]),
            (column("reversible", pa.bool_(), "the right answer"), [pair.reversible for pair in pairs]),
            (column("iou", pa.float64(), "IoU of the worse shape: of the transform if reversible, else the greatest "
                    "that refined trunks allow", "1"), [pair.worth for pair in pairs]),
            (column("file", pa.string(), "the transform, relative to the run's folder; empty = none"),
             [pair.file for pair in pairs]),
            (column("s_r_left", pa.float64(), "reversibility of the shape on the left", unit), reversible[left]),
            (column("s_r_right", pa.float64(), "reversibility of the shape on the right", unit), reversible[right]),
            (column("qcrs", pa.float64(), "QCRS of the pair", unit), [pair.quick for pair in pairs]),
            (column("crs", pa.float64(), "CRS of the pair", unit), [pair.cross for pair in pairs]),
            (column("qcrs_says", pa.bool_(), f"whether QCRS is above {threshold:g}, which says reversible"),
             [pair.quick > threshold for pair in pairs]),
            (column("crs_says", pa.bool_(), f"whether CRS is above {threshold:g}, which says reversible"),
             [pair.cross > threshold for pair in pairs]),
        ],
    )  # fmt: skip

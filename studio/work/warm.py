"""Make a process ready: load what answers need, by answering once."""

from __future__ import annotations

from riot.geometry.silhouette import polygon_shape
from riot.transform import shape_document
from studio.messages import Keep, Weight, flat_of
from studio.session.state import State
from studio.work.change import change
from studio.work.moving import plan_swing
from studio.work.reading import shape_file
from studio.work.search import alternative, best_transform

_HOUSE = ((0, 0), (4, 0), (4, 3), (2, 5), (0, 3))
_KITE = ((0, 3), (-2, 0), (0, -2), (2, 0))


def answer_once() -> None:
    """Load and run what answers need, so that a person does not wait for it."""
    shapes = [polygon_shape(points, name) for points, name in ((_HOUSE, "house"), (_KITE, "kite"))]
    p, q = (shape_file(shape_document.to_document(shape)) for shape in shapes)
    files = {p.digest: p.text, q.digest: q.text}
    answer = best_transform(State(p=p.digest, q=q.digest), files)
    files[answer.shown.digest] = answer.shown.text
    plan_swing(files, answer.shown.digest)
    alternative(answer.state, files, 0)
    for edit in (Keep("p", tuple(flat_of(shapes[0].points[:1]))), Weight(2.0)):
        change(answer.state, edit, files, quick=True)

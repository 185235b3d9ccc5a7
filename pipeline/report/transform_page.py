"""A transform's own page in the gallery: its card, how it moves, its puzzle, and where it comes from. Ours."""

from __future__ import annotations

from collections.abc import Sequence

from pipeline.report.card import Card
from pipeline.report.environment import render
from pipeline.report.gallery import INDEX, STYLE
from pipeline.report.pictures import silhouettes
from pipeline.report.rows import PuzzleRow, TransformRow
from pipeline.tables.record import GALLERY
from riot.motion.planner import motion_of
from riot.transform.provenance import describe_history
from riot.transform.transform import Transform


def transform_page(
    card: Card,
    transform: Transform,
    puzzle: PuzzleRow | None,
    files: Sequence[str],
    before: TransformRow | None,
    after: TransformRow | None,
    *,
    address: str = "",
) -> str:
    """The page of one card and its transform's motion, puzzle and history; it leads on to ``before`` and ``after``.

    ``files`` are those in the puzzle's folder; ``address`` is where the run's folder will be published, "" = nowhere.
    """
    return render(
        "transform.html",
        card=card,
        row=card.row,
        motion=None if card.row.approximate else motion_of(transform),
        puzzle=puzzle,
        files=files,
        silhouettes=silhouettes(transform),
        history=None if transform.history is None else "\n".join(describe_history(transform.history)),
        before=before,
        after=after,
        folder=address and f"{address}{GALLERY}/",
        index=INDEX,
        style=STYLE,
    )

"""Shapes of a mined collection as what the slices of a solid may become, for `riot slices --in RUN`. Ours."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from pipeline.match.search import open_mined
from pipeline.match.slices import shortlists
from pipeline.store.location import Location
from riot.geometry.shape import Shape
from riot.parameters import ShapeParameters
from riot.slices.assign import Shortlist

Search = Callable[[Sequence[Shape], int], Sequence[Shortlist]]


def search_run(folder: Path, store: Location | None, note: Callable[[str], None]) -> tuple[Search, ShapeParameters]:
    """A search of the run in ``folder`` for counterparts of slices, and how the run's outlines became shapes.

    ``note`` hears when the index has to be built. Raises as `pipeline.match.search.open_mined` does.
    """
    mined = open_mined(folder, store)
    return lambda cuts, keep: shortlists(mined, cuts, keep, note), mined.config.shape

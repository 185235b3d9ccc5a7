"""The history of a transform: the content keys of everything that it was computed from."""

from __future__ import annotations

from pipeline.stages.ingest import shape_key
from pipeline.store.artifact import canonical_json
from pipeline.store.keys import digest_text
from pipeline.tables.results import Results
from riot.transform.history import History, HistoryStep
from riot.transform.riot_file import add_history

OF_PAIR = ("crs", "refine", "construct", "motion")
"""Stages of a pair whose results its transform is computed from, in order. How pairs are selected does not matter."""


def pair_history(results: Results, pair: tuple[int, ...]) -> History:
    """The history of the transform of a pair; it is the same in every run that has the transform."""
    progress, keys = results.progress, _keys(results, pair)
    versions: dict[str, str] = {}
    for stage in keys:
        versions |= progress.recipes[stage].versions
    first, second = (progress.items[position].digest for position in pair)
    return History(
        maker="pipeline.run",
        pictures=(first, second),
        steps=tuple(
            HistoryStep(
                stage,
                progress.recipes[stage].values,
                digest_text(canonical_json(progress.recipes[stage].code)),
                of_stage,
            )
            for stage, of_stage in keys.items()
        ),
        versions=dict(sorted(versions.items())),
    )


def with_history(text: str | None, history: History) -> str | None:
    """The text of a ``.riot`` file with its history; None for None."""
    return None if text is None else add_history(text, history)


def _keys(results: Results, pair: tuple[int, ...]) -> dict[str, tuple[str, ...]]:
    """Keys of P's and Q's shapes and trunks, then those of the pair, by stage."""
    trunks = results.keys["trunks_full"]
    keys = {
        "ingest": tuple(shape_key(results.progress, position) for position in pair),
        "trunks_full": tuple(trunks[position,] for position in pair),
    }
    for stage in OF_PAIR:
        if pair in results.keys.get(stage, {}):
            keys[stage] = (results.keys[stage][pair],)
    return keys

"""Sentences that explain the counts of a run; the terminal and the report show the same ones."""

from __future__ import annotations

from collections.abc import Mapping

from pipeline.datasets.collection import PICTURES


def sentences(counts: Mapping[str, int], policy: str) -> list[str]:
    """Explain a run's ``counts`` (`pipeline.tables.record.counts`) where they may surprise; empty if none does."""
    return [
        *_doubtful(counts),
        *_trunks(counts),
        *_selection(counts, policy),
        *_approximate(counts),
        *_motions(counts),
        *_puzzles(counts),
        *_textures(counts),
        *_ignored(counts),
    ]


def several(count: int, singular: str, plural: str = "") -> str:
    """A number with its noun; ``plural`` is needed where the plural is not ``singular`` with an s.

    >>> several(1, "shape"), several(2000, "match", "matches")
    ('1 shape', '2,000 matches')
    """
    return f"{count:,} {singular if count == 1 else plural or singular + 's'}"


def _doubtful(counts: Mapping[str, int]) -> list[str]:
    doubtful = counts.get("doubtful", 0)
    if doubtful == 0:
        return []
    return [
        f"{several(doubtful, 'outline is', 'outlines are')} doubtful, and left out of the selection unless "
        "shape.doubtful=keep: look at check.html, which shows every outline on its picture."
    ]


def _trunks(counts: Mapping[str, int]) -> list[str]:
    without = counts.get("without_trunks", 0)
    if without == 0:
        return []
    return [
        f"{several(without, 'shape has', 'shapes have')} no trunk, so that every QCRS with "
        f"{'it' if without == 1 else 'them'} is 0 (column trunks of shapes.parquet)."
    ]


def _selection(counts: Mapping[str, int], policy: str) -> list[str]:
    if counts.get("selected", 0) or "classes" not in counts or counts.get("blocked", 0):
        return []
    shapes, classes = counts["shapes"], counts["classes"]
    if shapes < 2:
        why = f"a pair needs two shapes, and there {'is 1' if shapes == 1 else 'are none'}"
    elif classes < 2:
        what = "one shape of each class" if policy == "paper" else "shapes of different classes"
        why = f"select.policy={policy} pairs {what}, and all shapes are of one"
    else:
        why = "no two shapes that may be paired have a QCRS above 0"
    return [f"No pair was selected: {why}."]


def _approximate(counts: Mapping[str, int]) -> list[str]:
    approximate = counts.get("approximate", 0)
    if approximate == 0:
        return []
    return [
        f"{several(approximate, 'transform is', 'transforms are')} approximate, by the paper's method: pieces overlap "
        "and leave gaps (columns overlap_p to gap_q of transforms.parquet), and no motion is planned."
    ]


def _motions(counts: Mapping[str, int]) -> list[str]:
    planned, flat = counts.get("planned", 0), counts.get("swing_flat", 0)
    if planned == 0:
        return []
    sentence = f"{flat:,} of {several(planned, 'transform')} ({flat / planned:.0%}) can swing flat"
    if flat < planned:
        sentence += "; the others need telescopic hinges (column lifted_hinges of transforms.parquet)"
    return [f"{sentence}."]


def _puzzles(counts: Mapping[str, int]) -> list[str]:
    certified, refused = counts.get("puzzles", 0), counts.get("no_puzzles", 0)
    if certified + refused == 0:
        return []
    sentence = f"{certified:,} of {several(certified + refused, 'puzzle')} certified, in print/"
    return [f"{sentence}; fabrications.parquet says why the others cannot be made." if refused else f"{sentence}."]


def _textures(counts: Mapping[str, int]) -> list[str]:
    refused = counts.get("refused_textures", 0)
    if refused == 0:
        return []
    return [
        f"{several(refused, 'picture')} that may have colours cannot be a texture, so that pieces are plain on that "
        "side: no part is transparent, it is too large, or it has opaque parts beside the shape."
    ]


def _ignored(counts: Mapping[str, int]) -> list[str]:
    ignored = counts.get("ignored_files", 0)
    if ignored == 0:
        return []
    return [
        f"{several(ignored, 'file was', 'files were')} ignored: hidden, or of another kind than "
        f"{', '.join(sorted(PICTURES))}."
    ]

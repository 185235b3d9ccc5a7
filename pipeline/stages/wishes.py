"""The user's wishes for pairs, by names and classes: which shapes must be in a pair, and which must not (ours)."""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from pipeline.errors import StartError

if TYPE_CHECKING:
    from pipeline.config.selection import SelectConfig
    from pipeline.datasets.item import Item


@dataclass(frozen=True)
class WishedShapes:
    """Positions of shapes: of each group in ``groups`` one must be in a pair, none of those ``excluded``."""

    groups: tuple[tuple[int, ...], ...]
    excluded: tuple[int, ...]


def wished_shapes(settings: SelectConfig, items: Sequence[Item]) -> WishedShapes:
    """The shapes that the wishes name; a name that the collection lacks stands for none."""
    groups = []
    for wanted, kind in ((settings.classes, "cls"), (settings.shapes, "name")):
        if wanted:
            groups.append(tuple(k for k, item in enumerate(items) if getattr(item, kind) in wanted))
    excluded = tuple(k for k, item in enumerate(items) if {item.name, item.cls} & {*settings.exclude})
    return WishedShapes(tuple(groups), excluded)


def check_wishes(settings: SelectConfig, items: Sequence[Item]) -> None:
    """Raise `StartError` for a class or shape that the collection lacks, with the nearest that it has."""
    classes, names = {item.cls for item in items} - {""}, {item.name for item in items}
    for parameter, known, kind in (
        ("classes", classes, "class"),
        ("shapes", names, "shape"),
        ("exclude", classes | names, "shape or class"),
    ):
        for wanted in getattr(settings, parameter):
            if wanted not in known:
                nearest = difflib.get_close_matches(wanted, sorted(known), n=1, cutoff=0.5)
                hint = f"did you mean {nearest[0]}?" if nearest else _listed(sorted(known))
                raise StartError(f"select.{parameter}: the collection has no {kind} {wanted}; {hint}")


LISTED = 20
"""Most names in a message."""


def _listed(names: Sequence[str]) -> str:
    if not names:
        return "it has none at all"
    more = f" and {len(names) - LISTED:,} more" if len(names) > LISTED else ""
    return f"it has {', '.join(names[:LISTED])}{more}"

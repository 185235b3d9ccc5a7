"""How much a run shows: classes, pairs of classes and clusters of near-duplicates among its first transforms. Ours."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.study import plots
from pipeline.study.findings import Findings, Sheet, of_columns
from pipeline.study.finished import StudiedRun
from pipeline.study.results import OTHERS, Likenesses, beside, chosen_rows
from pipeline.tables.schemas import column
from riot.errors import needs_extra
from riot.parameters.field import ParameterGroup, parameter

with needs_extra("mine"):
    import pyarrow as pa

DEPTHS = (1, 6, 10, 25, 50, 100)
"""Ranks in the tables: the first screen of a report shows six."""


@dataclass(frozen=True)
class Parameters(ParameterGroup):
    """How many transforms are looked at, and of which runs."""

    top: int = parameter(100, at_least=1, meaning="Transforms of each run, the first by rank.")
    others: tuple[str, ...] = parameter((), meaning=OTHERS)


@dataclass(frozen=True)
class Shown:
    """What the first ``first`` transforms of a run show.

    ``repeated`` are pairs between two clusters that an earlier pair lies between, too.
    """

    run: str
    first: int
    classes: int
    class_pairs: int
    clusters: int
    repeated: int


def study(finished: StudiedRun, parameters: Parameters, say: Callable[[str], None]) -> Findings:
    """Count what the first k transforms show, for every k and each run."""
    say("near-duplicates of the collection …")
    shapes = Likenesses.of(finished)
    counts: list[Shown] = []
    for name, run in beside(finished, parameters.others).items():
        counts += _counts(name, run, shapes, parameters.top)
    of_run = {name: [count for count in counts if count.run == name] for name in dict.fromkeys(c.run for c in counts)}
    classes = len(set(finished.classes) - {""})
    clusters = len(np.unique(shapes.cluster))
    lead = "; ".join(
        f"the first {shown[-1].first} of {name} show {shown[-1].classes} of {classes} classes and "
        f"{shown[-1].clusters:,} of {clusters:,} clusters"
        for name, shown in of_run.items()
    )
    lines = {name: [(float(count.first), float(count.classes)) for count in shown] for name, shown in of_run.items()}
    of_clusters = {name: [(float(c.first), float(c.clusters)) for c in shown] for name, shown in of_run.items()}
    return Findings(
        f"Variety of {finished.mined.dataset}",
        f"{lead[0].upper()}{lead[1:]}.",
        _table(counts),
        [
            Sheet(
                f"The first {depth}",
                ("run", "classes", "pairs of classes", "clusters", "pairs between clusters shown before"),
                [
                    (name, *(str(value) for value in (at.classes, at.class_pairs, at.clusters, at.repeated)))
                    for name, shown in of_run.items()
                    for at in shown[depth - 1 : depth]
                ],
            )
            for depth in DEPTHS
            if any(len(shown) >= depth for shown in of_run.values())
        ],
        {
            "classes": (plots.curves(lines, "first transforms", "classes"), f"Classes shown, of {classes}"),
            "clusters": (plots.curves(of_clusters, "first transforms", "clusters"), f"Clusters shown, of {clusters:,}"),
        },
    )


def _counts(name: str, run: StudiedRun, shapes: Likenesses, top: int) -> list[Shown]:
    classes: set[str] = set()
    class_pairs: set[tuple[str, ...]] = set()
    clusters: set[int] = set()
    cluster_pairs: set[tuple[int, ...]] = set()
    counts = []
    for first, row in enumerate(chosen_rows(run)[:top], start=1):
        of_classes = tuple(sorted((row["class_i"], row["class_j"])))
        of_clusters = tuple(sorted(int(shapes.cluster[row[side]]) for side in ("i", "j")))
        classes |= set(of_classes) - {""}
        clusters |= set(of_clusters)
        class_pairs.add(of_classes)
        cluster_pairs.add(of_clusters)
        counts.append(Shown(name, first, len(classes), len(class_pairs), len(clusters), first - len(cluster_pairs)))
    return counts


def _table(counts: Sequence[Shown]) -> pa.Table:
    meanings = {
        "first": "so many transforms, the first by rank",
        "classes": "classes of their shapes",
        "class_pairs": "pairs of classes",
        "clusters": "clusters of near-duplicates of their shapes",
        "repeated": "pairs between two clusters that an earlier pair lies between, too",
    }
    return of_columns(
        "What the first transforms of each run show.",
        [
            (column("run", pa.string(), "policy of the run"), [count.run for count in counts]),
            *(
                (column(name, pa.int32(), meaning, "count"), [getattr(count, name) for count in counts])
                for name, meaning in meanings.items()
            ),
        ],
    )

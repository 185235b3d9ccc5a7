"""Writing a run's tables from the store, batch by batch and block row by block row, in one deterministic form."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from pipeline.stages.construct import DEFORMATION, FIDELITY, RESIDUALS
from pipeline.stages.crs import unpack_scores
from pipeline.stages.motion import COLUMNS as MOTION
from pipeline.stages.paper import COLUMNS as PAPER
from pipeline.stages.qcrs import COLUMNS
from pipeline.stages.refine import bound
from pipeline.store.artifact import Artifact
from pipeline.store.store import write_atomically
from pipeline.tables import schemas as tables
from pipeline.tables.history import pair_history, with_history
from pipeline.tables.outputs import (
    file_name,
    from_columns,
    from_rows,
    new_place,
    replace_folder,
    write_parquet,
    write_table,
)
from pipeline.tables.puzzles import write_puzzles
from pipeline.tables.results import Results, Row
from pipeline.tables.textures import write_skins
from riot.geometry.polyline import edge_lengths
from riot.scores.crs import NO_SCORE, CrossScore

TRANSFORMS = "transforms"


def write_tables(results: Results, folder: Path) -> list[Path]:
    """Write every table and the transforms' files into ``folder``; returns the files, sorted.

    Each table is written beside its place and then renamed; those of an earlier run are replaced.
    """
    folder.mkdir(parents=True, exist_ok=True)
    transforms = _transform_rows(results)
    written = [
        write_table(folder, "shapes", _shapes(results)),
        write_table(folder, "reversibility", _reversibility(results)),
        write_table(folder, "trunks", _trunks(results)),
        *_write_qcrs(results, folder),
        write_table(folder, "selected", [from_rows(tables.SELECTED, _selected(results))]),
        write_table(folder, "crs", [from_rows(tables.CRS, _crs(results))]),
        *_write_transforms(transforms, folder),
        *write_skins(results, transforms, folder),
        *write_puzzles(results, transforms, folder),
        write_table(folder, "errors", [from_rows(tables.ERRORS, results.errors)]),
        write_table(folder, "timings", [from_rows(tables.TIMINGS, _timings(results))]),
    ]
    return sorted(written)


def _shapes(results: Results) -> Iterator[pa.Table]:
    plan = results.plan
    for batch, ingest, trunks in zip(plan.batches, plan.ingest, plan.trunks, strict=True):
        shapes, found = results.artifact(ingest), results.artifact(trunks)
        if shapes is None:
            continue
        offsets = shapes.arrays["offsets"]
        rows = []
        for index, position in enumerate(batch):
            low, high = int(offsets[index]), int(offsets[index + 1])
            if low == high:
                continue
            points = shapes.arrays["points"][low:high]
            width, height = np.ptp(points, axis=0)
            item = plan.items[position]
            rows.append(
                {
                    "shape": int(results.numbers[position]),
                    "name": item.name,
                    "class": item.cls,
                    "source": results.source(item),
                    "digest": item.digest,
                    "points": high - low,
                    "features": int(shapes.arrays["feature"][low:high].sum()),
                    "sparse_points": None if found is None else int(found.arrays["sparse"][index]),
                    "trunks": None if found is None else int(np.diff(found.arrays["trunk_offsets"])[index]),
                    "perimeter": math.fsum(edge_lengths(np.asarray(points))),
                    "width": float(width),
                    "height": float(height),
                }
            )
        yield from_rows(tables.SHAPES, rows)


def _reversibility(results: Results) -> Iterator[pa.Table]:
    for batch, item in zip(results.plan.batches, results.plan.reversibility, strict=True):
        artifact = results.artifact(item)
        if artifact is None:
            continue
        numbers = results.numbers[batch.start : batch.stop]
        keep = numbers >= 0
        necks = np.diff(artifact.arrays["neck_offsets"])
        columns = {name: artifact.arrays[name][keep] for name in ("score", "s1", "s2", "waist")}
        yield from_columns(tables.REVERSIBILITY, shape=numbers[keep], necks=necks[keep], **columns)


def _trunks(results: Results) -> Iterator[pa.Table]:
    for batch, item in zip(results.plan.batches, results.plan.trunks, strict=True):
        artifact = results.artifact(item)
        if artifact is None:
            continue
        arrays = artifact.arrays
        counts = np.diff(arrays["trunk_offsets"])
        offsets = arrays["offsets"]
        total = len(arrays["areas"])
        perimeters = np.add.reduceat(arrays["edges"], offsets[:-1]) if total else np.empty(0)
        vertices = pa.ListArray.from_arrays(
            pa.array(offsets, type=pa.int32()), pa.array(arrays["vertices"], type=pa.int32())
        )
        yield from_columns(
            tables.TRUNKS,
            shape=np.repeat(results.numbers[batch.start : batch.stop], counts),
            trunk=np.arange(total) - np.repeat(arrays["trunk_offsets"][:-1], counts),
            n=np.diff(offsets),
            area=arrays["areas"],
            perimeter=perimeters,
            vertices=vertices,
        )


def _write_qcrs(results: Results, folder: Path) -> list[Path]:
    # A new folder that takes the old one's place, so that no part of an earlier run with more blocks stays.
    temporary = new_place(folder)
    names = []
    schema = tables.QCRS if results.search is None else results.search.schema()
    for a in range(len(results.plan.batches)):
        name = Path(f"i_block={a:04d}") / "part-0.parquet"
        (temporary / name).parent.mkdir(parents=True)
        write_parquet(temporary / name, schema, [_block_row(results, a).cast(schema)])
        names.append(name)
    temporary.mkdir(exist_ok=True)
    replace_folder(temporary, folder / "qcrs")
    return [folder / "qcrs" / name for name in names]


def _block_row(results: Results, a: int) -> pa.Table:
    """All pairs that there are with the first shape in batch ``a``, ordered by i and j."""
    parts = []
    for part in _kept_parts(results, a) if results.plan.pairs is not None else _block_parts(results, a):
        part |= {name: results.numbers[part[name]] for name in ("i", "j")}
        keep = (part["i"] >= 0) & (part["j"] >= 0)
        parts.append({name: column[keep] for name, column in part.items()})
    if not parts:
        return tables.QCRS.empty_table()
    columns = {name: np.concatenate([part[name] for part in parts]) for name in COLUMNS}
    # Blocks are ordered by (i, j), and all of one block's j come before the next one's.
    order = np.argsort(columns["i"], kind="stable")
    return from_columns(tables.QCRS, **{name: column[order] for name, column in columns.items()})


def _block_parts(results: Results, a: int) -> Iterator[dict[str, Any]]:
    """Columns of the blocks of a row, i and j by position."""
    for b in range(a, len(results.plan.batches)):
        artifact = results.artifact(results.plan.qcrs[a, b])
        if artifact is not None:
            part = {name: artifact.arrays[name] for name in COLUMNS}
            part["i"] = results.plan.batches[a].start + part["i"].astype(np.int64)
            part["j"] = results.plan.batches[b].start + part["j"].astype(np.int64)
            yield part


def _kept_parts(results: Results, a: int) -> Iterator[dict[str, Any]]:
    """Columns of the kept pairs of a row, i and j by position."""
    artifact = None if results.plan.pairs is None else results.artifact(results.plan.pairs)
    if artifact is not None:
        batch = results.plan.batches[a]
        low, high = np.searchsorted(artifact.arrays["i"], [batch.start, batch.stop])
        yield {name: artifact.arrays[name][low:high] for name in COLUMNS}


def _selected(results: Results) -> Iterator[Row]:
    for rank, (pair, score) in enumerate(zip(results.pairs, results.qcrs, strict=True), start=1):
        yield {"rank": rank, **_pair(results, pair), "qcrs": float(score)}


def _crs(results: Results) -> Iterator[Row]:
    refined = {item.members: item for item in results.work["refine"]}
    for rank, item in enumerate(results.work["crs"], start=1):
        artifact = results.artifact(item)
        if artifact is None:
            continue
        best, trunks = _best_score(artifact), results.artifact(refined[item.members])
        yield {
            "rank": rank,
            **_pair(results, item.members),
            **{name: getattr(best, name) for name in ("score", "s_edge", "s_angle", "s_area", "n", "evaluations")},
            "trunk_i": best.trunk_a.tolist(),
            "trunk_j": best.trunk_b.tolist(),
            "trunks_i": artifact.document["trunks_p"],
            "trunks_j": artifact.document["trunks_q"],
            "bound": None if trunks is None else bound(trunks),
        }


def _best_score(artifact: Artifact) -> CrossScore:
    scores = unpack_scores(artifact)
    return scores[0] if scores else NO_SCORE


def _write_transforms(rows: Sequence[Row], folder: Path) -> list[Path]:
    temporary = new_place(folder)
    temporary.mkdir()
    files = []
    for row in rows:
        if row["file"]:
            name = row["file"].removeprefix(f"{TRANSFORMS}/")
            write_atomically(temporary / name, row["riot"].encode())
            files.append(folder / TRANSFORMS / name)
    replace_folder(temporary, folder / TRANSFORMS)
    plain = [{name: value for name, value in row.items() if name != "riot"} for row in rows]
    return [write_table(folder, "transforms", [from_rows(tables.TRANSFORMS, plain)]), *files]


def _transform_rows(results: Results) -> list[Row]:
    """Rows of `transforms`, ranked, with the text of their file as ``riot``, None where there is none."""
    rows = []
    motions = {item.members: results.artifact(item) for item in results.work["motion"]}
    papers = {item.members: results.artifact(item) for item in results.work.get("paper", ())}
    crs = {item.members: (rank, item) for rank, item in enumerate(results.work["crs"], start=1)}
    for item in results.work["construct"]:
        selected, cross = crs[item.members]
        made, scored = results.artifact(item), results.artifact(cross)
        if made is None or scored is None or made.document["status"] == "failed":
            continue
        document, best = made.document, _best_score(scored)
        motion, paper = motions.get(item.members), papers.get(item.members)
        planned = {} if motion is None else motion.document
        compared = {} if paper is None else paper.document
        row: Row = {
            "selected": selected,
            **_pair(results, item.members),
            **{name: document[name] for name in ("status", "reason", "message")},
            "qcrs": float(results.qcrs[selected - 1]),
            "crs": best.score,
            **{name: getattr(best, name) for name in ("s_edge", "s_angle", "s_area")},
            "n": document.get("n", best.n),
            **{name: document.get(name) for name in (*DEFORMATION, *FIDELITY)},
            **{f"{name}_{side}": document.get(f"{name}_{side}") for name in ("bound", *RESIDUALS) for side in "pq"},
            **{name: planned.get(name) for name in MOTION},
            **{name: compared.get(name) for name in PAPER},
            "riot": with_history(planned.get("riot", document.get("riot")), pair_history(results, item.members)),
        }
        if "iou_p" in document:
            row["iou"] = min(document["iou_p"], document["iou_q"])
        rows.append(row)
    rows.sort(key=_least_deformed_first)
    for rank, row in enumerate(rows, start=1):
        name = f"{rank:04d}_{file_name(row['name_i'])}_{file_name(row['name_j'])}.riot"
        row |= {"rank": rank, "file": "" if row["riot"] is None else f"{TRANSFORMS}/{name}"}
    return rows


def _least_deformed_first(row: Row) -> tuple[int, float, int]:
    group = ("certified", "approximate", "rejected").index(row["status"])
    return (group, -row["iou"] if group < 2 else 0.0, row["selected"])


def _timings(results: Results) -> Iterator[Row]:
    for stage in results.stages:
        yield {"stage": stage.stage, "items": stage.total} | {
            name: getattr(stage, name)
            for name in (
                "cached",
                "computed",
                "failed",
                "blocked",
                "seconds",
                "cpu_seconds",
                "stored_seconds",
                "peak_mb",
            )
        }


def _pair(results: Results, members: tuple[int, ...]) -> Row:
    p, q = members
    first, second = results.plan.items[p], results.plan.items[q]
    return {
        "i": int(results.numbers[p]),
        "j": int(results.numbers[q]),
        "name_i": first.name,
        "name_j": second.name,
        "class_i": first.cls,
        "class_j": second.cls,
    }

"""A small finished run, made of exact pairs and invented scores, for tests of what reads a run's folder."""

import json
import math
from dataclasses import replace

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from pipeline.tables import schemas as tables
from riot.geometry.polyline import signed_area
from riot.geometry.wkb import outline_wkb
from riot.groundtruth.pairs import exact_pair, exact_transform
from riot.transform.certificate import certify
from riot.transform.deformation import measure_deformation
from riot.transform.riot_file import save

NAMES = (
    ("cat-1", "dog 2"),
    ("Tête & <b>'loup'</b>", 'qu"ote-é'),
    ("a-very-long-name-of-a-silhouette-that-somebody-typed-in-one-evening", "x"),
    ("</script><svg onload=1>", "../\x01\x7f"),
)


COMPARED = 2


def worn(transform, names, amplitude=0.02):
    """The transform with other inputs: a little different from what its pieces make."""

    def waved(shape, name):
        angle = np.arctan2(shape.points[:, 1], shape.points[:, 0])
        points = shape.points * (1.0 + amplitude * np.sin(5.0 * angle))[:, None]
        return replace(shape, points=points / np.sqrt(signed_area(points)), name=name)

    return replace(
        transform, p=waved(transform.p, names[0]), q=waved(transform.q, names[1]), bound_p=0.975, bound_q=0.97
    )


def transforms(count=4):
    """Transforms with 3 to 6 pieces and awkward names."""
    return [
        worn(exact_transform(exact_pair(3 + k % 4, 1 + k)), NAMES[k % len(NAMES)], 0.012 * (1 + k % 3))
        for k in range(count)
    ]


def write_fake_run(folder, exact=None, rejected=2, errors=3, shapes=40, approximate=(), fabrications=None):
    """Write a run's folder as the pipeline does; returns the transforms in order of rank.

    The first `COMPARED` are compared with invented ones by the paper's method; ``approximate`` ones are listed after.
    """
    exact = transforms() if exact is None else exact
    rng = np.random.default_rng(7)
    (folder / "transforms").mkdir(parents=True)
    exact = sorted(exact, key=lambda transform: -measure_deformation(transform).iou)
    rows = [_certified(folder, rank, transform) for rank, transform in enumerate(exact, start=1)]
    rows += [
        _certified(folder, rank, transform) | {"status": "approximate", "reason": "method", "message": "not exact"}
        for rank, transform in enumerate(approximate, start=len(exact) + 1)
    ]
    rows += [_rejected(len(rows) + k + 1) for k in range(rejected)]
    pairs = [(i, j) for i in range(shapes) for j in range(i + 1, shapes)]
    scores = rng.beta(1.2, 6.0, len(pairs))
    blocks = [
        {"i": i, "j": j, "score": s, "n": 4, "trunk_i": 0, "trunk_j": 0, "shift": 0}
        for (i, j), s in zip(pairs, scores, strict=True)
    ]
    blocks[5] |= {"score": 0.0, "n": 0}
    names = ["name_i", "name_j", "class_i", "class_j", "qcrs", "i", "j", "rank"]
    write(folder / "qcrs" / "i_block=0000" / "part-0.parquet", tables.SCHEMAS["qcrs"], blocks[:300])
    write(folder / "qcrs" / "i_block=0001" / "part-0.parquet", tables.SCHEMAS["qcrs"], blocks[300:])
    wkb = outline_wkb(exact_pair(3, 1).p)
    kinds = ("animal", "c0", "c1", "thing <2>", "Zoo")
    shape_rows = [
        {"shape": k, "name": f"s{k}", "class": kinds[k % 5] if k else "", "outline": wkb} for k in range(shapes)
    ]
    write_table(folder, "shapes", shape_rows)
    write_table(folder, "reversibility", [{"shape": k, "score": rng.beta(6, 2)} for k in range(shapes)])
    write_table(folder, "trunks", [])
    write_table(folder, "selected", [{name: row[name] for name in names} for row in rows])
    write_table(folder, "crs", [{"rank": row["rank"], "score": row["crs"], "n": row["n"]} for row in rows])
    write_table(folder, "transforms", rows)
    write_table(folder, "fabrications", [] if fabrications is None else fabrications)
    write_table(folder, "errors", [_error(k) for k in range(errors)])
    write_table(
        folder,
        "timings",
        [_timing(k, name) for k, name in enumerate(("ingest", "trunks", "qcrs", "construct", "paper"))],
    )
    facts = {
        "dataset": "fake & <small>",
        "started": "2024-01-01T00:00:00Z",
        "stages": [{"stage": "ingest", "seconds": 1.5}],
        "counts": {"shapes": shapes, "pairs": len(pairs)},
        "versions": {"numpy": "2.0.0", "riot-shapes": "0.1.0"},
        "config": {"crs": {"lines": 128}, "dataset": {"root": "<nowhere>", "roots": ["a", "b"], "limit": None}},
    }
    (folder / "run.json").write_text(json.dumps(facts), encoding="utf-8")
    return exact


def write_table(folder, name, rows):
    write(folder / f"{name}.parquet", tables.SCHEMAS[name], rows)


def write(path, schema, rows):
    path.parent.mkdir(parents=True, exist_ok=True)
    pq.write_table(pa.Table.from_pylist(list(rows), schema=schema), path)


def _certified(folder, rank, transform):
    deformation, certificate = measure_deformation(transform), certify(transform)
    file = f"transforms/{rank:04d}.riot"
    save(transform, folder / file)
    row = {"status": "certified", "reason": "", "message": "", "file": file, "n": len(transform)}
    row |= {name: getattr(deformation, name) for name in ("iou", "iou_p", "iou_q", "hausdorff_p", "hausdorff_q")}
    row |= {name: getattr(deformation, name) for name in ("mean_distance_p", "mean_distance_q")}
    for side, certified_side in (("p", certificate.p), ("q", certificate.q)):
        row |= {
            f"overlap_{side}": certified_side.overlap,
            f"gap_{side}": certified_side.gap,
            f"hinge_{side}": certified_side.hinge,
        }
    row |= {"bound_p": transform.bound_p, "bound_q": transform.bound_q, "change_ratio": 1.0 + 0.01 * rank}
    row |= {"cldice": 0.97, "centreline_recall_p": 0.97, "centreline_recall_q": 0.99}
    row |= {"bending_p": 1.25, "bending_q": 0.75, "direction_p": math.radians(1.5), "direction_q": math.radians(2.5)}
    if rank <= COMPARED:
        areas = {"paper_gaps": 0.0121, "paper_overlaps": 0.0232, "paper_outside": 0.0343}
        row |= {"paper_iou": row["iou"] - 0.01 * rank, "paper_hausdorff": 0.0454} | areas
    return row | _pair(rank, transform.p.name, transform.q.name)


def _rejected(rank):
    common = {
        "status": "rejected",
        "reason": "disconnected",
        "message": "cell 2 of <T> falls apart",
        "file": "",
        "n": 4,
    }
    return common | _pair(rank, f"frog & {rank}", "newt")


def _pair(rank, p, q):
    names = {"name_i": p, "name_j": q, "class_i": "animal", "class_j": "" if rank % 2 else "thing <2>"}
    scores = {"qcrs": 0.9 - 0.01 * rank, "crs": 0.8 - 0.01 * rank, "s_edge": 0.95, "s_angle": 0.9, "s_area": 0.85}
    return names | scores | {"rank": rank, "selected": rank, "i": rank, "j": rank + 1}


def _error(k):
    common = {"stage": "ingest", "key": "ab12", "type": "SilhouetteError", "reason": "one-colour", "attempts": 1}
    return common | {"item": f"bad <{k}>", "message": f"bad & <{k}>.png holds one colour; draw something"}


def _timing(k, name):
    counts = {"items": 40 * (k + 1), "cached": 10 * k, "computed": 30, "failed": k % 2, "blocked": 0}
    return {
        "stage": name,
        **counts,
        "seconds": 4.5 * 5.0**k,
        "cpu_seconds": 8.0,
        "stored_seconds": 9.0,
        "peak_mb": 300.5,
    }

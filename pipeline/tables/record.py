"""run.json: the record of a run, and the check that the run's folder still has the files that the record lists."""

from __future__ import annotations

import dataclasses
import json
import platform
from collections.abc import Mapping, Sequence
from importlib import metadata
from pathlib import Path
from typing import Any

from pipeline.plan.code_digest import code_digests, file_digest
from pipeline.stages.all import STAGES
from pipeline.stages.choose import chosen
from pipeline.store.artifact import canonical_json
from pipeline.store.keys import digest_bytes, digest_text
from pipeline.store.store import write_atomically
from pipeline.tables.results import Results
from riot.draw.texture.names import SIDES

RECORD = "run.json"
ARTIFACTS = "artifacts.json"
REPORT = "report.html"
CHECK = "check.html"
GALLERY = "gallery"
STUDY = "study"
FORMAT = "riot-run"
VERSION = 1
SHOWING = ("pipeline.tables.write", "pipeline.report.write", "pipeline.report.check", "pipeline.study.contents")
"""Modules whose code decides how tables and report look."""

LIBRARIES = (
    "numpy",
    "scipy",
    "numba",
    "shapely",
    "scikit-image",
    "pillow",
    "matplotlib",
    "pyarrow",
    "dask",
    "distributed",
)


def outcome_digest(results: Results, assets: str) -> str:
    """Digest of all that the tables and the report show, except times; ``assets`` is the digest of the templates."""
    items = [[item.name, item.cls, item.shown_source, item.digest] for item in results.progress.items]
    done = results.progress.done
    work = [[*item.reference, item.reference in done] for items in results.work.values() for item in items]
    code = {name: digest for module in SHOWING for name, digest in code_digests(module).items()}
    code |= {stage.module: file_digest(stage.module) for stage in STAGES}  # it says what the tables show of the stage
    return digest_text(
        canonical_json([VERSION, items, work, results.errors, code, assets, metadata.version("pyarrow")])
    )


def plain_config(config: Any) -> dict[str, Any]:
    """The configuration as JSON values."""
    return json.loads(json.dumps(dataclasses.asdict(config), default=str))  # type: ignore[no-any-return]


def write_record(
    folder: Path, results: Results, digest: str, files: Sequence[Path], exit_code: int, times: Mapping[str, Any]
) -> None:
    """Write ``artifacts.json``, the keys of the artifacts that the run needs, and then ``run.json``, its commit."""
    keys: dict[str, list[str]] = {}
    for stage, key in sorted(results.progress.done):
        keys.setdefault(stage, []).append(key)
    write_atomically(folder / ARTIFACTS, json.dumps(keys, indent=0).encode())
    record = {
        "format": FORMAT,
        "version": VERSION,
        "dataset": results.collection.name,
        "outcome": digest,
        "exit_code": exit_code,
        "configuration": plain_config(results.config),
        "store": results.store.text,  # the path in the configuration may be relative
        "versions": {
            "riot": metadata.version("riot-shapes"),
            "python": platform.python_version(),
            **{name: metadata.version(name) for name in LIBRARIES},
        },
        "counts": counts(results),
        "stages": [dataclasses.asdict(stage) for stage in results.stages],
        "times": dict(times),
        "files": {file.relative_to(folder).as_posix(): digest_bytes(file.read_bytes()) for file in files},
        "stamps": {file.relative_to(folder).as_posix(): stamp(file) for file in files},
    }
    write_atomically(folder / RECORD, json.dumps(record, indent=1, ensure_ascii=False).encode())


def counts(results: Results) -> dict[str, int]:
    """Count items, shapes, pairs, transforms, motions and errors.

    ``classes`` counts a shape without a class as a class of its own; ``doubtful`` counts the shapes that may have been
    read wrongly, ``without_trunks`` those that were searched for trunks and have none, ``refused_textures`` the colour
    pictures that cannot be textures, ``blocked`` the work items that were not tried because an input had failed.
    Certified and approximate ones are counted among the chosen, rejected ones among all that were ``constructed``.
    """
    constructions = [results.artifact(item) for item in results.work["construct"]]
    made = [artifact.document["status"] for artifact in constructions if artifact is not None]
    statuses = [results.progress.read(item).document["status"] for item in chosen(results.progress)]
    motions = [results.artifact(item) for item in results.work["motion"]]
    flat = [
        bool(artifact.document["swings_flat"])
        for artifact in motions
        if artifact is not None and "swings_flat" in artifact.document
    ]
    printed = [results.artifact(item) for item in results.work.get("fabricate", ())]
    puzzles = [
        artifact.document["status"] for artifact in printed if artifact is not None and "status" in artifact.document
    ]
    painted = [(item, results.artifact(item)) for item in results.work.get("paint", ())]
    refused = {
        item.members[SIDES.index(row["side"])]
        for item, artifact in painted
        if artifact is not None
        for row in artifact.document.get("refused", ())
    }
    shapes = results.shapes
    return {
        "items": len(results.progress.items) + len(results.collection.rejected),
        "ignored_files": results.collection.ignored,
        "shapes": shapes,
        "classes": results.classes,
        "doubtful": results.doubtful,
        "without_trunks": results.without_trunks,
        "rejected_items": len(results.progress.items) + len(results.collection.rejected) - shapes,
        "pairs": shapes * (shapes - 1) // 2,
        "selected": len(results.pairs),
        "certified": statuses.count("certified"),
        "approximate": statuses.count("approximate"),
        "rejected": made.count("rejected"),
        "constructed": len(made),
        "planned": len(flat),
        "swing_flat": sum(flat),
        "puzzles": puzzles.count("certified"),
        "no_puzzles": len(puzzles) - puzzles.count("certified"),
        "refused_textures": len(refused),
        "errors": len(results.errors),
        "blocked": results.blocked,
    }


def read_record(folder: Path) -> dict[str, Any] | None:
    """The record of a finished run; None when there is none that this version can read."""
    try:
        record = json.loads((folder / RECORD).read_bytes())
    except (OSError, ValueError):
        return None
    if not isinstance(record, dict) or record.get("format") != FORMAT or record.get("version") != VERSION:
        return None
    return record


def stamp(file: Path) -> list[int]:
    """Bytes of a file, and the time of its last change in nanoseconds."""
    status = file.stat()
    return [status.st_size, status.st_mtime_ns]


def is_up_to_date(folder: Path, digest: str) -> bool:
    """Whether ``folder`` holds a finished run of this outcome with its report and every file as it was written.

    A file of the size and time that the record has counts as unchanged, as in the store; the bytes of others are read.
    """
    record = read_record(folder)
    if record is None or record.get("outcome") != digest or REPORT not in record["files"]:
        return False
    stamps = record.get("stamps", {})
    try:
        return all(
            stamp(folder / name) == stamps.get(name) or digest_bytes((folder / name).read_bytes()) == written
            for name, written in record["files"].items()
        )
    except OSError:
        return False

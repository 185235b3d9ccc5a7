"""The tables of a run: one Arrow schema each, with the unit and the meaning of every column in its metadata.

`shape`, `i` and `j` are shape numbers: 0, 1, … in order of name, over the shapes of the run. Every table is plain
columns, so that pandas, Arrow, Dask and DuckDB read it without this project.
"""

from __future__ import annotations

from collections.abc import Mapping

import pyarrow as pa

RATIO = "1"
AREA = "unit-area frame"
MM, MM3 = "mm", "mm3"
SCORE = "score in [0, 1]"
OF_L_C = "L_c = 2*sqrt(pi)"
ANGLE = "rad"
BOUNDARY = "index of boundary point"


def column(name: str, kind: pa.DataType, meaning: str, unit: str = "") -> pa.Field:
    """A column with its meaning and unit as metadata."""
    return pa.field(name, kind, metadata={"meaning": meaning, "unit": unit})


def schema(meaning: str, *columns: pa.Field) -> pa.Schema:
    """Columns with the meaning of the table as metadata."""
    return pa.schema(list(columns), metadata={"meaning": meaning})


def _list(kind: pa.DataType) -> pa.DataType:
    # Parquet's own name for what a list holds, so that a table read back has the schema that was written.
    return pa.list_(pa.field("element", kind))


_PAIR = (
    column("i", pa.int32(), "first shape (P)", "shape number"),
    column("j", pa.int32(), "second shape (Q)", "shape number"),
)

_NAMES = (
    column("name_i", pa.string(), "name of the first shape"),
    column("name_j", pa.string(), "name of the second shape"),
    column("class_i", pa.string(), "class of the first shape, empty = none"),
    column("class_j", pa.string(), "class of the second shape, empty = none"),
)

SHAPES = schema(
    "The shapes of the run, in order of name.",
    column("shape", pa.int32(), "shape number, by which all tables join", "shape number"),
    column("name", pa.string(), "name of the shape, unique in the collection"),
    column("class", pa.string(), "class of the shape, empty = none"),
    column("source", pa.string(), "file, relative to the root of the collection, or definition of a sample"),
    column("digest", pa.string(), "SHA-256 of the source"),
    column("points", pa.int32(), "boundary points", "count"),
    column("features", pa.int32(), "main feature points among them", "count"),
    column("sparse_points", pa.int32(), "sparse boundary points, candidates for trunk vertices", "count"),
    column(
        "trunks",
        pa.int32(),
        "trunks that QCRS compares (tuned: full ones, else quick ones); with none, its every QCRS is 0",
        "count",
    ),
    column("perimeter", pa.float64(), "length of the boundary", AREA),
    column("width", pa.float64(), "extent in x", AREA),
    column("height", pa.float64(), "extent in y", AREA),
)

REVERSIBILITY = schema(
    "Reversibility score of every shape (paper §5.1); nan where it could not be computed.",
    column("shape", pa.int32(), "shape", "shape number"),
    column("score", pa.float64(), "S_r = min(s1, s2)", SCORE),
    column("s1", pa.float64(), "of the perimeter, equation 9", SCORE),
    column("s2", pa.float64(), "of the waists, equation 10", SCORE),
    column("waist", pa.float64(), "largest neck ratio among the waists, nan without a waist", RATIO),
    column("necks", pa.int32(), "necks found", "count"),
)

TRUNKS = schema(
    "Quick trunks, by shape and then by number of vertices and area.",
    column("shape", pa.int32(), "shape", "shape number"),
    column("trunk", pa.int32(), "number within the shape", "trunk number"),
    column("n", pa.int8(), "vertices", "count"),
    column("area", pa.float64(), "area of the trunk; the shape's is 1", AREA),
    column("perimeter", pa.float64(), "sum of the edge lengths", AREA),
    column("vertices", _list(pa.int32()), "vertices, counter-clockwise", BOUNDARY),
)

QCRS = schema(
    "Quick cross-reversibility score of every pair i < j (paper §5.2).",
    *_PAIR,
    column("score", pa.float64(), "QCRS; 0 when the two have no trunks of one size, nan where it was set aside", SCORE),
    column("n", pa.int8(), "vertices of the two trunks, 0 = none, −1 = set aside (table of errors)", "count"),
    column("trunk_i", pa.int32(), "the best pair's trunk of i, −1 = none", "trunk number"),
    column("trunk_j", pa.int32(), "the best pair's trunk of j, −1 = none", "trunk number"),
    column("shift", pa.int8(), "vertex k of trunk_i corresponds to (shift − k) mod n of trunk_j", "count"),
)

SELECTED = schema(
    "The pairs that went on to CRS and refined trunks, best QCRS first.",
    column("rank", pa.int32(), "1 = the best QCRS", "rank"),
    *_PAIR,
    *_NAMES,
    column("qcrs", pa.float64(), "QCRS of the pair", SCORE),
)

CRS = schema(
    "Cross-reversibility score of the selected pairs (paper §4.2).",
    column("rank", pa.int32(), "rank in `selected`", "rank"),
    *_PAIR,
    column("score", pa.float64(), "CRS = min(s_edge, s_angle, s_area) of the best pair of trunks", SCORE),
    column("s_edge", pa.float64(), "edge term, equation 3", SCORE),
    column("s_angle", pa.float64(), "angle term, equation 4", SCORE),
    column("s_area", pa.float64(), "area term, equation 5, of the worse direction", SCORE),
    column("n", pa.int8(), "vertices of the two trunks, 0 = none", "count"),
    column("trunk_i", _list(pa.int64()), "trunk of i, counter-clockwise", BOUNDARY),
    column("trunk_j", _list(pa.int64()), "trunk of j in corresponding order, clockwise", BOUNDARY),
    column("trunks_i", pa.int32(), "full trunks of i", "count"),
    column("trunks_j", pa.int32(), "full trunks of j", "count"),
    column("evaluations", pa.int64(), "area terms evaluated", "count"),
    column("bound", pa.float64(), "greatest IoU of the worse shape on refined trunks, 0 = no trunks will do", RATIO),
)

TRANSFORMS = schema(
    "Constructed transforms: certified, then approximate ones, least deformed first, then rejected ones as selected.",
    column("rank", pa.int32(), "1 = certified, with the greatest IoU of the worse shape", "rank"),
    column("selected", pa.int32(), "rank in `selected`", "rank"),
    *_PAIR,
    *_NAMES,
    column("status", pa.string(), "certified, approximate (not exact: the paper's method), or rejected"),
    column("reason", pa.string(), "why it was rejected, one word"),
    column("message", pa.string(), "why it was rejected, in words"),
    column("file", pa.string(), "the transform, relative to the run's folder; empty if rejected"),
    column("qcrs", pa.float64(), "QCRS of the pair", SCORE),
    column("crs", pa.float64(), "CRS of the pair", SCORE),
    column("s_edge", pa.float64(), "edge term of the CRS", SCORE),
    column("s_angle", pa.float64(), "angle term of the CRS", SCORE),
    column("s_area", pa.float64(), "area term of the CRS", SCORE),
    column("n", pa.int8(), "pieces", "count"),
    column("iou", pa.float64(), "intersection over union with the input, of the worse shape", RATIO),
    column("iou_p", pa.float64(), "of P with its input", RATIO),
    column("iou_q", pa.float64(), "of Q with its input", RATIO),
    column("bound_p", pa.float64(), "upper bound of iou_p for the trunks used", RATIO),
    column("bound_q", pa.float64(), "upper bound of iou_q for the trunks used", RATIO),
    column(
        "change_ratio", pa.float64(), "(1 − iou) / (1 − bound), the greater of P's and Q's; null = bound near 1", RATIO
    ),
    column("hausdorff_p", pa.float64(), "symmetric Hausdorff distance of P's outlines", OF_L_C),
    column("hausdorff_q", pa.float64(), "symmetric Hausdorff distance of Q's outlines", OF_L_C),
    column("mean_distance_p", pa.float64(), "mean distance of P's outlines", OF_L_C),
    column("mean_distance_q", pa.float64(), "mean distance of Q's outlines", OF_L_C),
    column("bending_p", pa.float64(), "bending energy of P's outline over the input's", RATIO),
    column("bending_q", pa.float64(), "bending energy of Q's outline over the input's", RATIO),
    column("direction_p", pa.float64(), "mean angle of P's outline to the input's at corresponding points", ANGLE),
    column("direction_q", pa.float64(), "mean angle of Q's outline to the input's at corresponding points", ANGLE),
    column("overlap_p", pa.float64(), "certificate: overlap of P's pieces", AREA),
    column("overlap_q", pa.float64(), "certificate: overlap of Q's pieces", AREA),
    column("gap_p", pa.float64(), "certificate: area that P's pieces leave open", AREA),
    column("gap_q", pa.float64(), "certificate: area that Q's pieces leave open", AREA),
    column("hinge_p", pa.float64(), "certificate: greatest distance at a hinge of P", AREA),
    column("hinge_q", pa.float64(), "certificate: greatest distance at a hinge of Q", AREA),
    column("swings_flat", pa.bool_(), "whether all pieces swing in one plane from P to Q, null = not planned"),
    column("lifted_hinges", _list(pa.int8()), "telescopic hinges: the pieces after one move a plane higher", "hinge"),
    column("open_hinge", pa.int8(), "the hinge that is open: hinge j is before piece j, null = not planned", "hinge"),
    column("motion_search", pa.string(), "which search found the motion, of several the last; null = not planned"),
    column("paper_iou", pa.float64(), "IoU of the worse shape by the paper's method; null = not compared", RATIO),
    column("paper_gaps", pa.float64(), "area of its gaps in the trunk of the greatest residual", AREA),
    column("paper_overlaps", pa.float64(), "area of its overlaps in that trunk", AREA),
    column("paper_outside", pa.float64(), "area of its pieces outside of that trunk", AREA),
    column("paper_hausdorff", pa.float64(), "symmetric Hausdorff distance of its worse shape", OF_L_C),
)

FABRICATIONS = schema(
    "Puzzles of the best transforms (paper §4.4), made as `fabricate` asks; none with fabricate.top=0.",
    column("rank", pa.int32(), "rank in `transforms`", "rank"),
    *_PAIR,
    *_NAMES,
    column("status", pa.string(), "certified, failed (a check of its certificate), or refused (cannot be made)"),
    column("reason", pa.string(), "why it failed or was refused, one word"),
    column("message", pa.string(), "why, in words, and which parameter would mend it"),
    column("folder", pa.string(), "its files, relative to the run's folder; empty unless certified"),
    column("size", pa.float64(), "long side of the larger shape", MM),
    column("thickness", pa.float64(), "of the pieces, in whole layers of the printer", MM),
    column("pin", pa.float64(), "diameter of the pins", MM),
    column("changes", _list(pa.string()), "parameters that were changed to make it (fabricate.fix)"),
    column("parts", pa.int16(), "parts to print, pins and sleeves among them", "count"),
    column("components", pa.int16(), "greatest number of connected solids in one part: 1", "count"),
    column("volume", pa.float64(), "of all pieces, pins and sleeves aside", MM3),
    column("least_wall", pa.float64(), "least width of a piece's layer where much hangs on it", MM),
    column("least_gap", pa.float64(), "least gap of two pieces found among samples of the motion; null = none", MM),
    column("proven_gap", pa.float64(), "what pieces keep apart at every moment, proven; null = not proven", MM),
    column("overlap", pa.float64(), "greatest volume of two parts in common, at the poses cut", MM3),
    column("poses", pa.int16(), "poses of the motion at which the solids were cut with each other", "count"),
    column("pin_hinges", pa.int8(), "hinges with a pin", "count"),
    column("telescopic_hinges", pa.int8(), "hinges that lift", "count"),
    column("warnings", _list(pa.string()), "what is weak or lost"),
)

ERRORS = schema(
    "What went wrong, by item; the run went on.",
    column("item", pa.string(), "name of the item, or the two names of a pair"),
    column("stage", pa.string(), "where it failed"),
    column("key", pa.string(), "content key of the work item, empty before there is one"),
    column("type", pa.string(), "type of the error"),
    column("reason", pa.string(), "reason in one word, where there is one"),
    column("message", pa.string(), "what, where, and what to do"),
    column("attempts", pa.int32(), "how often it was tried", "count"),
)

TIMINGS = schema(
    "What each stage cost in this run.",
    column("stage", pa.string(), "stage"),
    column("items", pa.int64(), "work items", "count"),
    column("cached", pa.int64(), "found in the store", "count"),
    column("computed", pa.int64(), "computed now", "count"),
    column("failed", pa.int64(), "failed", "count"),
    column("blocked", pa.int64(), "not tried, an input had failed", "count"),
    column("seconds", pa.float64(), "wall time of this run", "s"),
    column("cpu_seconds", pa.float64(), "processor time of all workers in this run", "s"),
    column("stored_seconds", pa.float64(), "time that the stage's artifacts took when they were computed", "s"),
    column("peak_mb", pa.float64(), "greatest resident memory of one worker up to then", "MiB"),
)

SWEEP = schema(
    "The jobs of a sweep, in order of its parameters, which come first.",
    column("status", pa.string(), "clean, errors (see the job's table of errors), refused (no start), or failed"),
    column("message", pa.string(), "why it was refused or failed"),
    column("folder", pa.string(), "folder of the job's tables, relative to the outputs; null if there are none"),
    column("items", pa.int64(), "items of the collection", "count"),
    column("shapes", pa.int64(), "items that became shapes", "count"),
    column("pairs", pa.int64(), "pairs of shapes", "count"),
    column("selected", pa.int64(), "pairs that went on to CRS", "count"),
    column("certified", pa.int64(), "certified transforms", "count"),
    column("approximate", pa.int64(), "approximate transforms", "count"),
    column("rejected", pa.int64(), "rejected constructions", "count"),
    column("swing_flat", pa.int64(), "certified transforms that swing in one plane", "count"),
    column("errors", pa.int64(), "rows of the job's table of errors", "count"),
    column("blocked", pa.int64(), "work items that were not tried", "count"),
    column("crs_max", pa.float64(), "best CRS of the selected pairs; null = none, as of the others", SCORE),
    column("crs_q90", pa.float64(), "CRS that nine tenths of them do not exceed", SCORE),
    column("crs_median", pa.float64(), "CRS that half of them do not exceed", SCORE),
    column("iou_max", pa.float64(), "best IoU of the worse shape of the certified transforms; null = none", RATIO),
    column("iou_q90", pa.float64(), "IoU that nine tenths of them do not exceed", RATIO),
    column("iou_median", pa.float64(), "IoU that half of them do not exceed", RATIO),
)

SCHEMAS = {
    "shapes": SHAPES,
    "reversibility": REVERSIBILITY,
    "trunks": TRUNKS,
    "qcrs": QCRS,
    "selected": SELECTED,
    "crs": CRS,
    "transforms": TRANSFORMS,
    "fabrications": FABRICATIONS,
    "errors": ERRORS,
    "timings": TIMINGS,
}
"""Every table by name; ``qcrs`` is a folder, partitioned by block row, the others ``<name>.parquet``."""


def with_parameters(schema: pa.Schema, kinds: Mapping[str, pa.DataType]) -> pa.Schema:
    """A table's schema after columns of the parameters that are swept over, of these types."""
    swept = [column(name, kind, "parameter that is swept over") for name, kind in kinds.items()]
    return pa.schema([*swept, *schema], metadata=schema.metadata)

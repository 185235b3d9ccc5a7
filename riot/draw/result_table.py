"""Results as rows: for a notebook's tables and for frames of pandas. Ours."""

from __future__ import annotations

from collections.abc import Iterable
from functools import singledispatch
from typing import TYPE_CHECKING, Any

import numpy as np

from riot.construction.plan import ConstructionPlan
from riot.draw.svg_text import escape
from riot.errors import needs_extra
from riot.scores.crs import CrossScore
from riot.scores.qcrs import QuickScore
from riot.scores.reversibility import Reversibility
from riot.scores.trunks import Trunks
from riot.transform.certificate import Certificate
from riot.transform.deformation import Deformation

if TYPE_CHECKING:
    import pandas

Row = dict[str, Any]

SHOWN_ROWS = 12
"""Rows of a table that a notebook shows."""


def to_frame(results: Any) -> pandas.DataFrame:
    """A result as a frame of pandas: a row for each trunk of `Trunks`, for each shape of a certificate or deformation.

    A score is one row; of a list of scores, plans (`riot.alternatives`) or other results come the rows of all, with
    their ``rank`` in the list. Lengths and areas are those of unit-area shapes.

    Raises
    ------
    MissingExtraError
        pandas is not installed.
    TypeError
        These are no results of ours.

    >>> from riot import alternatives
    >>> list(to_frame(alternatives(house, kite)).columns)
    ['rank', 'p', 'q', 'n', 'iou_bound', 'iou_bound_p', 'iou_bound_q']
    """
    with needs_extra("notebook"):
        import pandas
    return pandas.DataFrame(rows(results))


def table_html(results: Any) -> str:
    """The first rows of `rows` as an HTML table.

    >>> from riot import reversibility
    >>> table_html(reversibility(house)).count("<tr>")  # headings and a row
    2
    """
    every_row = rows(results)
    headings = "".join(f"<th>{escape(name)}</th>" for name in (every_row[0] if every_row else {}))
    body = "".join(
        f"<tr>{''.join(f'<td>{escape(_text(value))}</td>' for value in row.values())}</tr>"
        for row in every_row[:SHOWN_ROWS]
    )
    more = len(every_row) - SHOWN_ROWS
    note = f"<p>and {more} more rows; riot.to_frame has all</p>" if more > 0 else ""
    return f"<table><thead><tr>{headings}</tr></thead><tbody>{body}</tbody></table>{note}"


@singledispatch
def rows(results: Any) -> list[Row]:
    """A result, or a list of results, as rows of named values; raises TypeError for what is none.

    >>> from riot import qcrs
    >>> round(rows(qcrs(house, kite))[0]["qcrs"], 3)
    0.991
    """
    if isinstance(results, str) or not isinstance(results, Iterable):
        raise TypeError(f"a {type(results).__name__} is no result that has rows")
    return [{"rank": rank} | row for rank, result in enumerate(results, start=1) for row in rows(result)]


@rows.register
def _(trunks: Trunks) -> list[Row]:
    edges = np.split(trunks.edges, trunks.offsets[1:-1])
    return [
        {
            "trunk": trunk,
            "n": int(trunks.sizes[trunk]),
            "area": float(trunks.areas[trunk]),
            "shortest_edge": float(edges[trunk].min()),
            "longest_edge": float(edges[trunk].max()),
            "vertices": trunks.of(trunk).tolist(),
        }
        for trunk in range(len(trunks))
    ]


@rows.register
def _(plan: ConstructionPlan) -> list[Row]:
    return [
        {
            "p": plan.pair.p.name,
            "q": plan.pair.q.name,
            "n": len(plan.trunk_p),
            "iou_bound": plan.bound,
            "iou_bound_p": plan.bound_p,
            "iou_bound_q": plan.bound_q,
        }
    ]


@rows.register
def _(score: Reversibility) -> list[Row]:
    numbers = {"score": score.score, "s1": score.s1, "s2": score.s2, "waist": score.waist}
    return [numbers | {"necks": len(score.necks), "waists": int(score.waists.sum())}]


@rows.register
def _(score: QuickScore) -> list[Row]:
    return [{"qcrs": score.score, "trunk_a": score.trunk_a.tolist(), "trunk_b": score.trunk_b.tolist()}]


@rows.register
def _(score: CrossScore) -> list[Row]:
    terms = {"crs": score.score, "s_edge": score.s_edge, "s_angle": score.s_angle, "s_area": score.s_area}
    return [terms | {"n": score.n, "trunk_a": score.trunk_a.tolist(), "trunk_b": score.trunk_b.tolist()}]


@rows.register
def _(certificate: Certificate) -> list[Row]:
    return [
        {"shape": name, "passed": not side.failures, "overlap": side.overlap, "gap": side.gap, "hinge": side.hinge}
        for name, side in (("P", certificate.p), ("Q", certificate.q))
    ]


@rows.register
def _(deformation: Deformation) -> list[Row]:
    names = ["iou", "hausdorff", "mean_distance"]
    if deformation.bent:
        names += ["input_iou", "rms_strain", "max_strain"]
    return [
        {"shape": side.upper()} | {name: getattr(deformation, f"{name}_{side}") for name in names}
        for side in ("p", "q")
    ]


def _text(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.4g}"
    return ", ".join(map(str, value)) if isinstance(value, list) else str(value)

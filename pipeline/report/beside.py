"""The section that sets the paper's method beside the exact one."""

from __future__ import annotations

from collections.abc import Mapping

from pipeline.report.comparison import Compared, Comparison, Made
from pipeline.report.markup import SHOWN_PAIRS, linked, number, seconds, section, small, table
from riot.draw.svg import escape

HEAD = (
    "pair", "IoU, exact", "paper’s", "residual, exact", "gaps, paper’s", "overlaps", "outside",
    "Hausdorff / L<sub>c</sub>, exact", "paper’s",
)  # fmt: skip


def beside(comparison: Comparison, links: Mapping[int, str]) -> str:
    """The section: the best pairs and the medians of all, the other pairs folded; ``links`` lead to ranks."""
    rows = [_cells(_name(pair, links), pair.exact, pair.paper) for pair in comparison.pairs]
    medians = _cells(f"<b>median of {len(rows)}</b>", *comparison.medians)
    note = (
        "The best transforms, made by the paper’s method too on the same trunks. IoU and Hausdorff distance are of the "
        "worse shape; gaps, overlaps and pieces outside are areas in the trunk that has more of them (shapes have 1). "
        f"Mean time of a pair: {seconds(comparison.seconds_exact)} exact, which may try more than one pair of trunks, "
        f"and {seconds(comparison.seconds_paper)} the paper’s."
    )
    numeric = (False, *(True,) * 8)
    body = table(HEAD, [*rows[:SHOWN_PAIRS], medians], numeric, "Both methods, pair by pair")
    if len(rows) > SHOWN_PAIRS:
        rest = table(HEAD, rows[SHOWN_PAIRS:], numeric, "Both methods, the other pairs")
        body += f"<details><summary>the other {len(rows) - SHOWN_PAIRS}</summary>{rest}</details>"
    return section("beside", "Beside the paper’s method", f'<div class="sheet">{body}</div>', note)


def _name(pair: Compared, links: Mapping[int, str]) -> str:
    return linked(links, pair.rank, f"{escape(pair.name_p)} ⇄ {escape(pair.name_q)}")


def _cells(name: str, exact: Made, paper: Made) -> list[str]:
    return [
        f'<div class="pair">{name}</div>',
        number(exact.iou),
        number(paper.iou),
        small(exact.residual),
        *(number(value, 4) for value in (paper.gaps, paper.overlaps, paper.outside)),
        number(exact.hausdorff, 4),
        number(paper.hausdorff, 4),
    ]

"""What a greater σ_A of QCRS gains and costs, on the trunks of both variants: how the tuned one was chosen. Ours."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import combinations_with_replacement
from typing import Any

import numpy as np

from pipeline.study import plots
from pipeline.study.consistency import uniform
from pipeline.study.findings import Findings, Sheet, encoded, of_columns
from pipeline.study.finished import StudiedRun
from pipeline.study.partners import StudiedPartners
from pipeline.study.registry import TIMES
from pipeline.study.statistics import Agreement, agreement
from pipeline.tables.schemas import column
from riot.errors import needs_extra
from riot.parameters import QCRS_VARIANTS, QcrsParameters, QcrsVariant
from riot.parameters.field import ParameterGroup, parameter
from riot.scores.qcrs import score_block, score_pairs
from riot.scores.trunk_stack import TrunkStack, stack
from riot.scores.trunks import compared_trunks

with needs_extra("mine"):
    import pyarrow as pa


@dataclass(frozen=True)
class Parameters(ParameterGroup):
    """The values of σ_A, and the sizes of the samples."""

    sigma_area: tuple[float, ...] = parameter(
        (0.05, 0.1, 0.15, 0.2, 0.3, 0.5), above=0, unit="areas", meaning="Values of σ_A beside each variant's own."
    )
    pairs: int = parameter(3000, at_least=3, meaning="Random pairs on which orders are compared.")
    draws: int = parameter(1000, at_least=1, meaning="Pairs of these pairs whose orders are compared.")
    shapes: int = parameter(
        120, at_least=2, meaning="Random shapes whose pairs are all scored in blocks, as in a run, to measure prices."
    )
    repeats: int = parameter(3, at_least=1, meaning="Measurements of each price, in turn.")
    seed: int = parameter(2018, at_least=0, meaning="Seed of the samples.")


@dataclass(frozen=True)
class Choice:
    """A σ_A on the trunks of a variant: agreement with CRS, and CPU time as a multiple of the paper variant's."""

    variant: QcrsVariant
    sigmas: QcrsParameters
    own: bool
    agreed: Agreement
    price: float


def study(finished: StudiedRun, parameters: Parameters, say: Callable[[str], None]) -> Findings:
    """Agreement with CRS and price of every value, on the trunks of both variants.

    The sigmas of edges and angles are the variant's own. Prices go to `TIMES` and to the page, not to the table, since
    they differ between equal runs.
    """
    rng = np.random.default_rng(parameters.seed)
    pairs = uniform(len(finished.mined.names), parameters.pairs, rng)
    drawn = np.sort(rng.permutation(len(finished.mined.names))[: parameters.shapes])
    settings = finished.config
    partners = StudiedPartners(finished.shapes, settings.trunks, settings.refine, settings.crs)
    say(f"CRS of {len(pairs)} pairs …")
    cross = np.array([partners.cross(i, j) for i, j in pairs.tolist()])
    agreements: list[tuple[QcrsVariant, QcrsParameters, Agreement]] = []
    batches: dict[QcrsVariant, list[TrunkStack]] = {}
    for variant, own_sigmas in QCRS_VARIANTS.items():
        say(f"QCRS on the trunks of the {variant} variant …")
        trunks = [compared_trunks(shape, variant, settings.trunks) for shape in finished.shapes]
        stacked = stack(trunks)
        size = math.ceil(len(drawn) / math.ceil(len(drawn) / settings.batch))
        batches[variant] = [
            stack([trunks[k] for k in drawn[start : start + size].tolist()]) for start in range(0, len(drawn), size)
        ]
        for value in sorted({*parameters.sigma_area, own_sigmas.sigma_area}):
            sigmas = replace(own_sigmas, sigma_area=value)
            quick = score_pairs(stacked, stacked, pairs, sigmas).score
            agreements.append((variant, sigmas, agreement(quick, cross, parameters.draws, parameters.seed)))
    say(f"prices, {parameters.repeats} times …")
    prices = _prices(
        [(batches[variant], sigmas) for variant, sigmas, _ in agreements], batches["paper"], parameters.repeats
    )
    choices = [
        Choice(variant, sigmas, sigmas == QCRS_VARIANTS[variant], agreed, price)
        for (variant, sigmas, agreed), price in zip(agreements, prices, strict=True)
    ]
    return _findings(finished, choices)


def _prices(
    work: Sequence[tuple[Sequence[TrunkStack], QcrsParameters]], reference: Sequence[TrunkStack], repeats: int
) -> list[float]:
    """CPU time of each piece of work as a multiple of the paper variant's just after it: the median of the repeats."""
    ratios = np.array([
        [_seconds(batches, sigmas) / _seconds(reference, QCRS_VARIANTS["paper"]) for batches, sigmas in work]
        for _ in range(repeats)
    ])  # fmt: skip
    return [float(price) for price in np.median(ratios, axis=0)]


def _seconds(batches: Sequence[TrunkStack], sigmas: QcrsParameters) -> float:
    begun = time.process_time()
    for first, second in combinations_with_replacement(batches, 2):
        score_block(first, second, sigmas)
    return time.process_time() - begun


def _findings(finished: StudiedRun, choices: Sequence[Choice]) -> Findings:
    # Said of orders alone: the lead goes into the table, and prices differ between equal runs.
    own_orders = "; ".join(
        f"{choice.agreed.alike} of {choice.agreed.drawn} draws ({choice.agreed.low:.1%} to {choice.agreed.high:.1%}) "
        f"by {choice.sigmas.sigma_area:g} on the trunks of the {choice.variant} variant"
        for choice in choices
        if choice.own
    )
    rows = [
        (
            choice.variant + ", its own" * choice.own,
            f"{choice.sigmas.sigma_area:g}",
            f"{choice.agreed.alike} of {choice.agreed.drawn}",
            f"{choice.agreed.low:.1%} – {choice.agreed.high:.1%}",
            *(
                f"{value:.3f}"
                for value in (choice.agreed.share, choice.agreed.halved, choice.agreed.kendall, choice.agreed.spearman)
            ),
            f"{choice.price:.2f} ×",
        )
        for choice in choices
    ]
    return Findings(
        f"σ_A of QCRS on {finished.mined.dataset}",
        f"Two random pairs of shapes are ordered as by CRS in {own_orders}. "
        "A greater σ_A orders more alike and costs more.",
        _table(choices),
        [Sheet("Order and price",
               ("trunks", "σ_A", "alike", "95 %", "of all", "ties half", "Kendall", "Spearman", "price"), rows)],
        {"sigmas": (
            plots.curves(
                {variant: [(choice.price, choice.agreed.share) for choice in choices if choice.variant == variant]
                 for variant in QCRS_VARIANTS},
                "CPU time / the paper variant's", "share ordered as by CRS",
            ),
            "What σ_A gains and costs; it grows along each line, upwards where it gains",
        )},
        {TIMES: encoded(_times(choices))},
    )  # fmt: skip


def _table(choices: Sequence[Choice]) -> pa.Table:
    return of_columns(
        "Agreement of QCRS with CRS by σ_A.",
        [
            *_named(choices),
            (column("own", pa.bool_(), "whether this is the variant's own"), [choice.own for choice in choices]),
            (column("alike", pa.int32(), "draws ordered alike", "count"), [choice.agreed.alike for choice in choices]),
            (column("drawn", pa.int32(), "draws", "count"), [choice.agreed.drawn for choice in choices]),
            (column("share", pa.float64(), "share of all pairs of pairs ordered alike"),
             [choice.agreed.share for choice in choices]),
            (column("halved", pa.float64(), "the same, those that QCRS ties counting half"),
             [choice.agreed.halved for choice in choices]),
            (column("kendall", pa.float64(), "Kendall's τ_b"), [choice.agreed.kendall for choice in choices]),
            (column("spearman", pa.float64(), "Spearman's ρ"), [choice.agreed.spearman for choice in choices]),
        ],
    )  # fmt: skip


def _named(choices: Sequence[Choice]) -> list[tuple[pa.Field, list[Any]]]:
    """The columns that tell a row of both tables from the others."""
    return [
        (column("variant", pa.string(), "variant whose trunks are compared"), [choice.variant for choice in choices]),
        (
            column("sigma_area", pa.float64(), "sigma of the area term"),
            [choice.sigmas.sigma_area for choice in choices],
        ),
    ]


def _times(choices: Sequence[Choice]) -> pa.Table:
    return of_columns(
        "Price of QCRS by σ_A; it varies from run to run.",
        [
            *_named(choices),
            (column("price", pa.float64(), "CPU time as a multiple of the paper variant's", "1"),
             [choice.price for choice in choices]),
        ],
    )  # fmt: skip

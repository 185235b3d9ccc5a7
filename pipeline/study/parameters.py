"""What the method's parameters do (paper §6): to the candidate trunks, and to the order of shapes by reversibility."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np
from matplotlib.figure import Figure

from pipeline.study import plots
from pipeline.study.findings import Findings, Sheet, encoded, of_columns
from pipeline.study.finished import StudiedRun
from pipeline.study.groundtruth import PIECES
from pipeline.study.hidden import hide
from pipeline.study.ordering import SigmaOrder, orders
from pipeline.study.registry import TIMES
from pipeline.study.statistics import wilson
from pipeline.study.varied import TrunkOutcome, vary
from pipeline.tables.schemas import column
from riot.draw.palette import LIGHT
from riot.draw.palette import PIECES as COLOURS
from riot.errors import needs_extra
from riot.groundtruth.limits import PairLimits
from riot.parameters.field import ParameterGroup, parameter

with needs_extra("mine"):
    import pyarrow as pa

TRUNKS, SIGMAS = ("spacing", "tau_s", "tau_c"), ("sigma_pa", "sigma_w")
"""The parameters of candidate trunks, and those of S_r."""

SYMBOLS = {"spacing": "L_c / d_space", "tau_s": "τ_s", "tau_c": "τ_c", "sigma_pa": "σ_PA", "sigma_w": "σ_W"}

PAPER = {
    "spacing": "15; 22–54 sparse points a shape",
    "tau_s": "0.1; 0.07 for two of the nine designs by hand",
    "tau_c": "0.3",
    "sigma_pa": "1",
    "sigma_w": "4",
}
"""The paper's value, and what it says of it."""


MARGINS = {
    False: f"with hinges within {PairLimits().corner_tolerance:g} of corners and pieces deeper than "
    f"{PairLimits().least_depth:g}, "
    "which a greater τ_s must lose",
    True: "with hinges anywhere and shallow pieces among them",
}
"""What the exact pairs are like, by whether their margins are narrow."""

Varied = TypeVar("Varied", TrunkOutcome, SigmaOrder)


@dataclass(frozen=True)
class Parameters(ParameterGroup):
    """The values of each parameter beside the run's own, which always is among them, and the sizes of the samples."""

    spacing: tuple[float, ...] = parameter((8.0, 10.0, 12.0, 18.0, 22.0), above=0, meaning="Values of L_c / d_space.")
    tau_s: tuple[float, ...] = parameter((0.05, 0.07, 0.14, 0.2), above=0, unit="√area", meaning="Values of τ_s.")
    tau_c: tuple[float, ...] = parameter((0.05, 0.1, 0.2, 0.5, 0.7), above=0, below=1, meaning="Values of τ_c.")
    sigma_pa: tuple[float, ...] = parameter((0.25, 0.5, 2.0, 4.0), above=0, meaning="Values of σ_PA.")
    sigma_w: tuple[float, ...] = parameter((1.0, 2.0, 8.0, 16.0), above=0, meaning="Values of σ_W.")
    pairs: int = parameter(60, at_least=1, meaning="Exact pairs in whose shapes trunks are looked for.")
    shapes: int = parameter(200, at_least=1, meaning="Shapes of the run in which trunks are counted.")
    narrow: bool = parameter(
        True,
        meaning="The exact pairs keep narrow margins (`pipeline.study.hidden.hide`): the generator's own margins fit "
        "the default values, so that others would look worse than they are.",
    )
    seed: int = parameter(2018, at_least=0, meaning="Seed of the sample of shapes.")


def study(finished: StudiedRun, parameters: Parameters, say: Callable[[str], None]) -> Findings:
    """Vary one parameter at a time. CPU times go to `TIMES`, beside the table, since they differ between equal runs."""
    pairs, _ = hide(parameters.pairs, PIECES, narrow=parameters.narrow)
    hidden = [side for pair in pairs for side in (pair.p, pair.q)]
    count = len(finished.shapes)
    rng = np.random.default_rng(parameters.seed)
    sample = [finished.shapes[k] for k in np.sort(rng.permutation(count)[: parameters.shapes]).tolist()]
    values = {name: getattr(parameters, name) for name in TRUNKS}
    outcomes = list(vary(hidden, sample, finished.config.trunks, values, say))
    times = _times(outcomes, say)
    s1, s2 = (finished.values("reversibility", name) for name in ("s1", "s2"))
    run_sigmas = {name: float(getattr(finished.config.reversibility, name)) for name in SIGMAS}
    sigma_orders = list(orders(s1, s2, run_sigmas, {name: getattr(parameters, name) for name in SIGMAS}))
    return replace(_findings(finished, parameters, outcomes, sigma_orders), files={TIMES: times})


def _times(outcomes: Sequence[TrunkOutcome], say: Callable[[str], None]) -> bytes:
    """The table of times; reports each time as well."""
    default_seconds = next(outcome.seconds for outcome in outcomes if outcome.default)
    for outcome in outcomes:
        say(
            f"{outcome.parameter}={outcome.value:g}: {1e3 * outcome.seconds:.1f} ms a shape, "
            f"{outcome.seconds / default_seconds:.2f} × the default"
        )
    table = of_columns(
        "CPU time of the full trunks of one shape; these vary from run to run.",
        [
            (column("parameter", pa.string(), "parameter that is varied"), [outcome.parameter for outcome in outcomes]),
            (column("value", pa.float64(), "its value"), [outcome.value for outcome in outcomes]),
            (column("seconds", pa.float64(), "mean of one shape", "s"), [outcome.seconds for outcome in outcomes]),
            (
                column("ratio", pa.float64(), "to that of the default", "1"),
                [outcome.seconds / default_seconds for outcome in outcomes],
            ),
        ],
    )
    return encoded(table)


def _findings(
    finished: StudiedRun, parameters: Parameters, outcomes: Sequence[TrunkOutcome], orders: Sequence[SigmaOrder]
) -> Findings:
    hidden_shapes, counted = len(outcomes[0].error), len(outcomes[0].trunks)
    trunk_rows = [
        (SYMBOLS[row.parameter], _value(row), f"{row.found} of {hidden_shapes}",
         "{:.0%} – {:.0%}".format(*wilson(row.found, hidden_shapes, together=2)), f"{row.mean_error:.4f}",
         f"{np.median(row.trunks):.0f}", f"{row.trunks.mean():.0f}")
        for row in outcomes
    ]  # fmt: skip
    lost_rows = [(SYMBOLS[row.parameter], _value(row), _lost(row)) for row in outcomes if row.lost]
    order_rows = [(SYMBOLS[row.parameter], _value(row), f"{row.kendall:.3f}", f"{row.kept:.0%}") for row in orders]
    findings_by_name = {**_trunk_words(outcomes), **_order_words(orders)}
    words = [(SYMBOLS[name], PAPER[name], here) for name, here in findings_by_name.items()]
    return Findings(
        f"Parameters on {finished.mined.dataset}",
        f"One parameter at a time, the others as the run has them. True trunks are those of {hidden_shapes} shapes of "
        f"exact pairs, drawn as pictures, {MARGINS[parameters.narrow]}; they are found if a candidate trunk is near at "
        f"every corner. Trunks are counted in {counted} shapes of the run. The order by S_r is that of all its shapes, "
        f"and depends on the ratio of the two sigmas alone. Times are in {TIMES} beside this page.",
        _table(outcomes, orders),
        [
            Sheet("Findings", ("parameter", "paper", "here"), words, 3),
            Sheet("Candidate trunks", ("parameter", "value", "true trunks found", "95 %", "mean error / L_c",
                                       "median trunks", "mean"), trunk_rows),
            Sheet("True trunks lost at", ("parameter", "value", "test"), lost_rows, 3),
            Sheet("Order by S_r", ("parameter", "value", "Kendall's τ", "of the best tenth kept"), order_rows),
        ],
        {
            "recovery": (_lines(_series(outcomes, lambda row: row.found / hidden_shapes), "true trunks found"),
                         "Share of true trunks that are near a candidate trunk"),
            "error": (_lines(_series(outcomes, lambda row: row.mean_error), "mean error / L_c"),
                      "Greatest distance of a corner from its true place, of the nearest candidate trunk"),
            "trunks": (_lines(_series(outcomes, lambda row: float(np.median(row.trunks))), "trunks a shape", True),
                       "Median number of candidate trunks"),
            "order": (_lines(_series(orders, lambda row: row.kendall), "Kendall's τ to the default"),
                      "How far the order of the shapes by S_r stays"),
        },
    )  # fmt: skip


def _value(row: TrunkOutcome | SigmaOrder) -> str:
    return f"{row.value:g}" + " (run)" * row.default


def _lost(outcome: TrunkOutcome) -> str:
    return ", ".join(
        f"{test} {count}" for test, count in sorted(outcome.lost.items(), key=lambda item: (-item[1], item[0]))
    )


def _trunk_words(outcomes: Sequence[TrunkOutcome]) -> dict[str, str]:
    """A sentence or two on each parameter of candidate trunks, from the values."""
    words = {}
    for name in dict.fromkeys(outcome.parameter for outcome in outcomes):
        varied = [outcome for outcome in outcomes if outcome.parameter == name]
        default = next(outcome for outcome in varied if outcome.default)
        best, worst = (
            max(varied, key=lambda outcome: (outcome.found, outcome.default)),
            min(varied, key=lambda outcome: outcome.found),
        )
        clauses = [f"{default.found} of {len(default.error)} true trunks with {default.value:g}"]
        clauses.append("no value finds more" if best.default else f"the most, {best.found}, with {best.value:g}")
        if worst.found < default.found:
            test, count = max(sorted(worst.lost.items()), key=lambda item: item[1])
            clauses.append(f"the fewest, {worst.found}, with {worst.value:g} ({count} lost at: {test})")
        counts = [f"{np.median(outcome.trunks):.0f} with {outcome.value:g}" for outcome in (varied[0], varied[-1])]
        words[name] = f"{'; '.join(clauses)}. Median trunks of a shape of the run: {', '.join(counts)}."
    return words


def _order_words(orders: Sequence[SigmaOrder]) -> dict[str, str]:
    """A sentence on each sigma that was varied, from the values."""
    words = {}
    for name in dict.fromkeys(order.parameter for order in orders):
        others = [order for order in orders if order.parameter == name and not order.default]
        if others:
            worst = min(others, key=lambda order: order.kendall)
            words[name] = (
                f"The order stays to a Kendall's τ of {worst.kendall:.2f} at least (with {worst.value:g}, which keeps "
                f"{worst.kept:.0%} of the best tenth)."
            )
    return words


def _series(rows: Sequence[Varied], measure: Callable[[Varied], float]) -> dict[str, tuple[list[float], list[float]]]:
    """By parameter: its values over the default's, and a measure."""
    series: dict[str, tuple[list[float], list[float]]] = {}
    for name in dict.fromkeys(row.parameter for row in rows):
        varied = [row for row in rows if row.parameter == name]
        default = next(row.value for row in varied if row.default)
        series[SYMBOLS[name]] = [row.value / default for row in varied], [measure(row) for row in varied]
    return series


def _lines(series: Mapping[str, tuple[list[float], list[float]]], y: str, logarithmic: bool = False) -> Figure:
    figure, plot = plots.axes("value / the run's own", y)
    for number, (name, (factors, values)) in enumerate(series.items()):
        plot.plot(factors, values, "o-", color=COLOURS[number], markersize=4.0, linewidth=1.6, label=name)
    plot.axvline(1.0, color=LIGHT["muted"], linewidth=0.8, linestyle=":")
    plot.set_xscale("log", base=2)
    plot.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    if logarithmic:
        plot.set_yscale("log")
    else:
        plot.set_ylim(bottom=0.0)
    plot.legend(frameon=False)
    return figure


def _table(outcomes: Sequence[TrunkOutcome], orders: Sequence[SigmaOrder]) -> pa.Table:
    rows: list[TrunkOutcome | SigmaOrder] = [*outcomes, *orders]

    def trunk(name: str, kind: pa.DataType, meaning: str, unit: str, value: Callable[[TrunkOutcome], Any]) -> Any:
        return column(name, kind, meaning, unit), [*map(value, outcomes), *([None] * len(orders))]

    def order(name: str, meaning: str, value: Callable[[SigmaOrder], float]) -> Any:
        return column(name, pa.float64(), meaning, "1"), [*([None] * len(outcomes)), *map(value, orders)]

    return of_columns(
        "One parameter at a time: what it does to candidate trunks, or to the order by S_r; null = not concerned.",
        [
            (column("parameter", pa.string(), "parameter that is varied; spacing is L_c / d_space"),
             [row.parameter for row in rows]),
            (column("value", pa.float64(), "its value"), [row.value for row in rows]),
            (column("default", pa.bool_(), "whether it is the run's own"), [row.default for row in rows]),
            trunk("hidden", pa.int32(), "shapes of exact pairs", "count", lambda row: len(row.error)),
            trunk("found", pa.int32(), "of these, with a candidate trunk near the true one", "count",
                  lambda row: row.found),
            trunk("error", pa.float64(), "mean distance, at its worst corner, of the nearest trunk from the true one",
                  "L_c = 2*sqrt(pi)", lambda row: row.mean_error),
            trunk("without", pa.int32(), "of these, without a trunk of as many corners", "count",
                  lambda row: int(np.isinf(row.error).sum())),
            trunk("lost_at", pa.string(), "tests that leave nothing near a true trunk, and how often", "", _lost),
            trunk("trunks_median", pa.float64(), "candidate trunks of a shape of the run, median", "count",
                  lambda row: float(np.median(row.trunks))),
            trunk("trunks_mean", pa.float64(), "candidate trunks of a shape of the run, mean", "count",
                  lambda row: float(row.trunks.mean())),
            order("kendall", "Kendall's tau of S_r with that of the run's own sigmas", lambda row: row.kendall),
            order("kept", "share of the best tenth by S_r that stays there", lambda row: row.kept),
        ],
    )  # fmt: skip

"""The command `riot trunks A B`: the trunk pairs that `riot make` can be told to use. Ours."""

from __future__ import annotations

import argparse

from riot.cli.common_options import add_inputs, add_pieces
from riot.cli.complaints import doubtful_outline
from riot.cli.inputs import read_inputs
from riot.cli.output import Output
from riot.cli.parser import Parser
from riot.cli.table import Table
from riot.construction.plan_search import alternatives
from riot.kernels.warm import compile_used


def add_options(parser: Parser) -> None:
    """See `riot.cli.command.CommandModule`."""
    add_inputs(parser)
    add_pieces(parser)


def run(chosen: argparse.Namespace, output: Output) -> int:
    """See `riot.cli.command.CommandModule`."""
    a, b = read_inputs(chosen.a, chosen.b)
    for path, shape in ((chosen.a, a), (chosen.b, b)):
        for doubt in doubtful_outline(path, shape):
            output.complain(doubt)
    compile_used(output.note, __name__)
    pairs = [
        {"rank": rank, "pieces": len(plan.trunk_p), "bound_p": plan.bound_p, "bound_q": plan.bound_q}
        for rank, plan in enumerate(alternatives(a, b, pieces=chosen.pieces), start=1)
    ]
    table = Table(
        ("rank", "pieces", f"IoU {a.name} ≤", f"IoU {b.name} ≤"),
        [
            (str(pair["rank"]), str(pair["pieces"]), f"{pair['bound_p']:.4f}", f"{pair['bound_q']:.4f}")
            for pair in pairs
        ],
        "Refined trunk pairs",
    )
    names = {"p": a.name, "q": b.name}
    output.facts({"inputs": names, "trunk_pairs": pairs}, table)
    return 0

"""The commands of two files, by name, for the program `riot`; each is loaded when it is called."""

from __future__ import annotations

from collections.abc import Sequence

from riot import cli
from riot.cli.command import Command, Group
from riot.cli.program import run_program

SUMMARY = "find shapes that turn inside out into each other, and build the puzzle that does it"

COMMANDS = {
    "make": Command("turn one silhouette inside out into another", lambda: cli.make),
    "trunks": Command("list the trunk pairs that make can be told to use", lambda: cli.trunks),
    "show": Command("print the numbers of a .riot file", lambda: cli.show),
    "print": Command("make the solids of a .riot file for a 3D printer", lambda: cli.print_puzzle),
    "coupon": Command("make test pieces that measure a printer's clearances and a laser's kerf", lambda: cli.coupon),
    "slices": Command("cut a solid into thick slices, each a puzzle that becomes another shape", lambda: cli.slices),
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one of these commands; returns its exit code."""
    return run_program("riot", Group(SUMMARY, COMMANDS), arguments)

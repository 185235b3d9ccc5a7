"""What a program consists of: commands, and groups of commands. Ours."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

from riot.cli.output import Output
from riot.cli.parser import Parser


class CommandModule(Protocol):
    """What a command does: usually a module."""

    def add_options(self, parser: Parser, /) -> None:
        """Declare options, and describe the exit codes, with the command's ``parser``."""

    def run(self, chosen: argparse.Namespace, output: Output, /) -> int:
        """Do what was ``chosen``; returns the exit code. Raises `riot.errors.RiotError` or OSError if it cannot."""


@dataclass(frozen=True)
class Command:
    """A command: its summary in the list of commands, and how to load it, which happens when it is called."""

    summary: str
    load: Callable[[], CommandModule]
    extra: str = ""
    """The extra of the package that it needs, empty if the base will do."""
    interruption: str = ""
    """What is said when Ctrl-C ends it, empty if only that it did."""

    def parser(self, program: str) -> Parser:
        """The parser of the command, called ``program`` in messages."""
        parser = Parser(program, self.summary)
        self.load().add_options(parser)
        return parser


@dataclass(frozen=True)
class Group:
    """Commands by name; ``noun`` is what messages call one of them."""

    summary: str
    commands: Mapping[str, Command | Group]
    noun: str = "command"
    plural: str = "commands"
    exit_codes: Mapping[int, str] | None = None

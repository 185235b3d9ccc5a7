"""The parser of a command: the options that all commands share, suggestions for wrong ones, and exit codes. Ours."""

from __future__ import annotations

import argparse
import difflib
import shutil
import textwrap
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, NoReturn

from riot.errors import RiotError

WIDEST = 100
"""Columns of a help text on a wide terminal (ours)."""

NARROWEST = 40
"""Columns below which a help text does not fit (ours): the terminal breaks its lines."""

DONE, REFUSED, INTERRUPTED, PIPE_CLOSED = 0, 2, 130, 141
"""Exit codes that all commands share; 141 is what a shell shows for a program that SIGPIPE ends."""

EXIT_CODES = {DONE: "Done.", REFUSED: "It could not be done; the message says why."}

SHARED = {
    "-h": ("--help", "print this text, and stop"),
    "--version": ("", "print the version of RIOT, and stop"),
    "-q": ("--quiet", "print nothing but errors"),
    "-v": ("--verbose", "print more, also where an error comes from"),
    "--json": ("", "print JSON instead of lines and tables"),
}
"""Options of every command: the names of each, and its meaning."""


class UsageError(RiotError, ValueError):
    """A command line that names what there is not, or lacks what is needed."""


class Parser(argparse.ArgumentParser):
    """An argument parser that raises `UsageError`, and whose help ends with sections of its own."""

    def __init__(self, program: str, summary: str) -> None:
        super().__init__(prog=program, description=sentence(summary), allow_abbrev=False, add_help=False)
        self._positionals.title = "arguments"
        self.exit_codes: Mapping[int, str] = EXIT_CODES
        self.sections: list[Callable[[], str]] = []
        """Make the texts of the help between options and exit codes."""
        self.flags: dict[str, str] = {}
        """Options by the parameter of the library that each sets, whose name messages use."""
        self.names: Callable[[], Mapping[str, Sequence[str]]] = dict
        """The names that a ``name=value`` may have, and the values of each to choose from."""
        self.shared = self.add_argument_group("options of every command")
        self.takes_json = True

    def parse(self, arguments: Sequence[str]) -> argparse.Namespace:
        """Parse; the namespace has the shared options as well. Raises `UsageError`."""
        self.complete()
        for argument in arguments:
            option = argument.partition("=")[0]
            if option.startswith("--") and option not in {*self.options(), "--"}:
                raise UsageError(self._unknown(option))
        return self.parse_intermixed_args(arguments)

    def complete(self) -> None:
        """Add the shared options, which come last in the help."""
        if "--help" in self._option_string_actions:
            return
        for name, (longer, meaning) in SHARED.items():
            if name != "--json" or self.takes_json:
                names = [name, longer] if longer else [name]
                self.shared.add_argument(*names, action="store_true", help=meaning)

    def error(self, message: str) -> NoReturn:
        """Raise `UsageError` instead of ending the process."""
        raise UsageError(message)

    def options(self) -> dict[str, argparse.Action]:
        """The options by name; those that the help does not list come last."""
        return dict(sorted(self._option_string_actions.items(), key=lambda item: item[1].help == argparse.SUPPRESS))

    def positionals(self) -> list[argparse.Action]:
        """The arguments that are no options."""
        return self._get_positional_actions()

    def format_help(self) -> str:
        """Usage, options, sections, exit codes."""
        more = (section() for section in self.sections)
        return "\n".join([self.options_help(), *more, listing("exit codes", self.exit_codes)])

    def options_help(self) -> str:
        """Usage and options."""
        self.complete()
        return super().format_help()

    def _unknown(self, option: str) -> str:
        """The message for an option that there is not; a parameter of the same name may be meant."""
        word = option.lstrip("-").replace("-", "_")
        meant = [name for name in self.names() if name.rpartition(".")[2] == word]
        if meant:
            return f"{option}: no such option. Did you mean {' or '.join(f'{name}=…' for name in meant)}?"
        listed = [name for name, action in self.options().items() if action.help != argparse.SUPPRESS]
        return unknown(option, [name for name in listed if name.startswith("--")], "option", "options")

    def _get_formatter(self) -> argparse.HelpFormatter:
        return argparse.HelpFormatter(self.prog, max_help_position=28, width=columns())

    def parameter_option(self, name: str, parameter: str, **settings: Any) -> None:
        """Add an option that sets a parameter of the library: messages about this then name the option."""
        self.flags[parameter] = name
        self.add_argument(name, dest=parameter, **settings)


def columns() -> int:
    """Width of help texts: that of the terminal, between `NARROWEST` and `WIDEST`."""
    return max(NARROWEST, min(shutil.get_terminal_size().columns, WIDEST))


def listing(title: str, meanings: Mapping[Any, str]) -> str:
    """A title and a list of names with their meanings, wrapped to the terminal.

    >>> print(listing("exit codes", {0: "Done."}))
    exit codes:
      0  Done.
    <BLANKLINE>
    """
    return "\n".join([f"{title}:", *listed(meanings, columns()), ""])


def listed(meanings: Mapping[Any, str], width: int) -> Iterator[str]:
    """Names with their meanings in a column, a line or more for each."""
    column = max((len(str(name)) for name in meanings), default=0) + 4
    for name, meaning in meanings.items():
        indent = f"  {name}".ljust(column)
        yield textwrap.fill(meaning, width, initial_indent=indent, subsequent_indent=" " * column)


def unknown(name: str, allowed: Iterable[str], noun: str, plural: str) -> str:
    """The message for a name that there is not: the nearest one, and all of them.

    >>> unknown("mkae", ["make", "show"], "command", "commands")
    'mkae: no such command. Did you mean make? The commands are make, show'
    """
    known = {other.lstrip("-"): other for other in allowed}
    nearest = difflib.get_close_matches(name.lstrip("-"), known, n=1)
    hint = f" Did you mean {known[nearest[0]]}?" if nearest else ""
    return f"{name}: no such {noun}.{hint} The {plural} are {', '.join(known.values())}"


def sentence(text: str) -> str:
    """A summary as a sentence of its own.

    >>> sentence("list the studies")
    'List the studies.'
    """
    return f"{text[:1].upper()}{text[1:]}." if text else ""

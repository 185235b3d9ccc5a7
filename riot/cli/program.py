"""Run a program: find the command, parse its options, call it, and end as its outcome says. Ours."""

from __future__ import annotations

import contextlib
import io
import os
import sys
import textwrap
import time
import traceback
from collections.abc import Mapping, Sequence
from dataclasses import replace
from importlib import metadata

from riot.cli.command import Command, Group
from riot.cli.interrupts import interruptible
from riot.cli.output import Output
from riot.cli.parser import (
    DONE,
    INTERRUPTED,
    PIPE_CLOSED,
    REFUSED,
    SHARED,
    UsageError,
    columns,
    listed,
    listing,
    sentence,
    unknown,
)
from riot.errors import DISTRIBUTION, RiotError, needs_extra

HELP, VERSION = frozenset({"-h", "--help"}), "--version"
FLAGS = frozenset(name for short, (longer, _) in SHARED.items() for name in (short, longer) if name)


def run_program(
    program: str,
    entry: Command | Group,
    arguments: Sequence[str] | None = None,
    words: Mapping[str, str] | None = None,
    command: str = "",
) -> int:
    """Run the command line ``arguments``, by default those of the process; returns the exit code.

    ``program`` is its name as typed, and ``command`` its own name, if it has one. ``words`` and ``command``: see
    `riot.cli.output.Output`.

    >>> run_program("riot", Group("nothing", {}), ["--version"])  # doctest: +ELLIPSIS
    riot ...
    0
    """
    arguments = sys.argv[1:] if arguments is None else arguments
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")  # a terminal that lacks a character costs nobody a result
    try:
        code = _dispatch(Output(program, words=words or {}, command=command), entry, list(arguments))
        sys.stdout.flush()  # here, where a reader that has gone can still be told from an error
        return code
    except BrokenPipeError:
        return _end_quietly()
    except KeyboardInterrupt:
        return INTERRUPTED


def group_help(program: str, group: Group) -> str:
    """What ``--help`` of a group of commands prints."""
    shared = {", ".join(filter(None, (name, longer))): meaning for name, (longer, meaning) in SHARED.items()}
    summaries = {name: entry.summary for name, entry in group.commands.items()}
    lines = [
        f"usage: {program} {group.noun.upper()} [option …]\n",
        f"{textwrap.fill(sentence(group.summary), columns())}\n",
        listing(group.plural, summaries),
        listing("options of every command", shared),
    ]
    if group.exit_codes:
        lines.append(listing("exit codes", group.exit_codes))
    return "\n".join([*lines, f"`{program} {group.noun.upper()} --help` lists the options of a {group.noun}."])


def version() -> str:
    """The version of RIOT."""
    return metadata.version(DISTRIBUTION)


def _dispatch(output: Output, entry: Command | Group, arguments: list[str]) -> int:
    flags: list[str] = []
    try:
        while isinstance(entry, Group):
            while arguments and arguments[0].startswith("-"):
                flag = arguments.pop(0)
                if flag not in FLAGS:
                    raise UsageError(f"{unknown(flag, FLAGS, 'option', 'options')}; other options follow {entry.noun}s")
                flags.append(flag)
            if VERSION in flags or not HELP.isdisjoint(flags):
                print(f"riot {version()}" if VERSION in flags else group_help(output.program, entry))
                return DONE
            if not arguments:
                names = "\n".join(listed({name: of.summary for name, of in entry.commands.items()}, columns()))
                raise UsageError(f"name a {entry.noun}; there are\n{names}")
            name = arguments.pop(0)
            if name not in entry.commands:
                raise UsageError(unknown(name, entry.commands, entry.noun, entry.plural))
            program, command = f"{output.program} {name}", f"{output.command} {name}"
            output, entry = replace(output, program=program, command=command), entry.commands[name]
    except UsageError as error:
        return _misused(output, error)
    with interruptible(entry.interruption or f"{output.program}: interrupted"):
        return _run(output, entry, [*flags, *arguments])


def _run(output: Output, command: Command, arguments: Sequence[str]) -> int:
    output = replace(output, verbose="-v" in arguments or "--verbose" in arguments)
    if VERSION in arguments:
        print(f"riot {version()}")
        return DONE
    started = time.perf_counter()
    try:
        with needs_extra(command.extra) if command.extra else contextlib.nullcontext():
            parser = command.parser(output.program)
            if not HELP.isdisjoint(arguments):
                print(output.worded(parser.format_help()), end="")
                return DONE
            chosen = parser.parse(arguments)
            chosen.arguments = [argument for argument in arguments if argument not in FLAGS]
            output = replace(
                output,
                json=parser.takes_json and chosen.json,
                quiet=chosen.quiet,
                verbose=chosen.verbose,
                words={**output.words, **parser.flags},
            )
            code = command.load().run(chosen, output)
    except BrokenPipeError:
        raise
    except UsageError as error:
        return _misused(output, error)
    except (RiotError, OSError) as error:
        return _refused(output, error, message(error))
    output.detail(f"{time.perf_counter() - started:.1f} s")
    return code


def message(error: Exception) -> str:
    """What an error says to a user."""
    if isinstance(error, OSError) and not isinstance(error, RiotError) and error.filename and error.strerror:
        return f"{error.filename}: {error.strerror}; check the path"
    return str(error)


def _refused(output: Output, error: Exception, text: str) -> int:
    if output.verbose:
        traceback.print_exception(error)
    output.complain(text)
    return REFUSED


def _misused(output: Output, error: UsageError) -> int:
    output.complain(f"{error}\n`{output.program} --help` says more")
    return REFUSED


def _end_quietly() -> int:
    """End as a program does that SIGPIPE ends: Python would complain once more when it closes standard output."""
    with contextlib.suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return PIPE_CLOSED

"""The command `riot completion SHELL`: a script that completes commands, options, choices and ``name=value``. Ours.

The script of a shell, in `shells/`, reads a table of what may be typed where, a line ``command|kind|word|meaning`` for
each word. Kinds: ``c`` a command, ``o`` an option alone, ``p`` one that a path follows, ``a`` one that another value
follows, ``v`` the value of an option or a name, ``n`` the name of a parameter; ``f`` says that files may be given.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import resources
from pathlib import Path

from riot.cli.command import Command, Group
from riot.cli.output import Output
from riot.cli.parser import DONE, SHARED, Parser

SHELLS = ("bash", "zsh", "fish")
TABLE = "@TABLE@"
"""Where the table goes in a script."""

INSTALL = {
    "bash": 'eval "$(riot completion bash)", in ~/.bashrc to keep it',
    "zsh": 'eval "$(riot completion zsh)", after compinit, in ~/.zshrc to keep it',
    "fish": "riot completion fish | source, in ~/.config/fish/config.fish to keep it",
}


@dataclass(frozen=True)
class CompletionCommand:
    """The command for the program ``root``."""

    root: Group

    def add_options(self, parser: Parser) -> None:
        """See `riot.cli.command.CommandModule`."""
        parser.add_argument("shell", choices=SHELLS, metavar="SHELL", help=" or ".join(SHELLS))
        parser.takes_json = False
        lines = "\n".join(f"  {shell}: {how}" for shell, how in INSTALL.items())
        parser.sections.append(lambda: f"how to install the script:\n{lines}\n")

    def run(self, chosen: argparse.Namespace, output: Output) -> int:
        """See `riot.cli.command.CommandModule`."""
        output.show(script(self.root, chosen.shell).rstrip("\n"))
        return DONE


def script(root: Group, shell: str) -> str:
    """The script of a shell for all commands of a program; raises ValueError for a shell that there is none for."""
    if shell not in SHELLS:
        raise ValueError(f"{shell}: no such shell; choose one of {', '.join(SHELLS)}")
    template = (resources.files("riot.cli") / "shells" / f"completion.{shell}").read_text(encoding="utf-8")
    text = "\n".join(table(root))
    return template.replace(TABLE, text.replace("\\", "\\\\").replace("'", "\\'") if shell == "fish" else text)


def table(root: Group, path: str = "") -> Iterator[str]:
    """What may be typed where, a line each.

    >>> list(table(Group("nothing", {"sub": Group("less", {})})))[0]
    '|c|sub|less'
    """
    for name, entry in root.commands.items():
        below = f"{path} {name}".strip()
        yield f"{path}|c|{name}|{entry.summary}"
        if isinstance(entry, Group):
            yield from table(entry, below)
        else:
            yield from _command_lines(entry, below)
    for short, (longer, meaning) in SHARED.items():
        yield from (f"{path}|o|{name}|{meaning}" for name in (short, longer) if name)


def _command_lines(command: Command, path: str) -> Iterator[str]:
    try:
        parser = command.parser(path)
    except ModuleNotFoundError:  # its extra is not installed: the command has nothing to complete yet
        return
    parser.complete()
    for name, action in parser.options().items():
        if action.help == argparse.SUPPRESS:
            continue
        kind = "o" if action.nargs == 0 else "p" if action.type is Path else "a"
        yield f"{path}|{kind}|{name}|{' '.join(str(action.help).split())}"
        yield from (f"{path}|v|{name} {choice}|" for choice in action.choices or ())
    for name, choices in parser.names().items():
        yield f"{path}|n|{name}=|"
        yield from (f"{path}|v|{name}={choice}|" for choice in choices)
    for action in parser.positionals():
        if action.type is Path:
            yield f"{path}|f||"
        yield from (f"{path}|c|{choice}|" for choice in action.choices or ())

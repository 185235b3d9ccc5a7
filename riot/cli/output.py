"""The one place where commands print: facts as lines and tables or as JSON, notes on standard error. Ours."""

from __future__ import annotations

import json
import math
import re
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from riot.cli.table import Table

VERSION = 1
"""Version of the JSON documents; a change that a reader notices raises it."""


ASCII = str.maketrans({"⇄": "<>", "─": "-", "≤": "<=", "–": "-", "…": "...", "×": "x", "’": "'"})
"""What stands for our own characters on a terminal that lacks them."""


@dataclass(frozen=True)
class Output:
    """How a command prints: ``program`` is its name as the user typed it, such as ``riot make``.

    ``command`` is its own name, without that of the program, such as ``make``: JSON documents have it.
    ``words`` has what messages call things, and what the user calls each: the library names a parameter, the user an
    option.
    """

    program: str
    json: bool = False
    quiet: bool = False
    verbose: bool = False
    words: Mapping[str, str] = field(default_factory=dict)
    command: str = ""

    def facts(self, document: Mapping[str, Any], *shown: str | Table) -> None:
        """Print facts: ``document`` if the user wants JSON, else what is ``shown``, lines and tables."""
        self.show(*shown)
        self.document(document)

    def show(self, *shown: str | Table) -> None:
        """Print lines (text as it stands) and tables, unless the user wants JSON or quiet."""
        if self.json or self.quiet:
            return
        for entry in shown:
            for line in entry.lines() if isinstance(entry, Table) else [entry]:
                print(encodable(self.worded(line), sys.stdout.encoding))

    def document(self, document: Mapping[str, Any]) -> None:
        """Print a JSON document if the user wants JSON: format, version, and the facts of a command."""
        if self.json:
            whole = {"format": "-".join(("riot", *self.command.split())), "version": VERSION, **document}
            text = json.dumps(_plain(whole), indent=1, ensure_ascii=False, allow_nan=False)
            if not _encodes(text, sys.stdout.encoding):
                text = json.dumps(_plain(whole), indent=1, allow_nan=False)
            print(text)

    def note(self, text: str) -> None:
        """Say on standard error what goes on."""
        if not self.quiet:
            print(f"{self.program}: {self.worded(text)}", file=sys.stderr)

    def detail(self, text: str) -> None:
        """Say on standard error what only a verbose user wants to know."""
        if self.verbose:
            self.note(text)

    def complain(self, text: str) -> None:
        """Say on standard error what is wrong, also to who wants quiet."""
        print(f"{self.program}: {self.worded(text)}", file=sys.stderr)

    def worded(self, text: str) -> str:
        """A message in the words of the user.

        >>> Output("riot print", words={"size_mm": "--size"}).worded("enlarge size_mm (30)")
        'enlarge --size (30)'
        """
        if not self.words:
            return text
        names = "|".join(map(re.escape, sorted(self.words, key=len, reverse=True)))
        return re.sub(rf"(?<![\w.])(?:{names})(?!\w)", lambda match: self.words[match[0]], text)


def encodable(text: str, encoding: str | None) -> str:
    """A text with ASCII for our own characters that an encoding lacks.

    >>> encodable("bird ⇄ fish", "cp1252")
    'bird <> fish'
    """
    return text if _encodes(text, encoding) else text.translate(ASCII)


def _encodes(text: str, encoding: str | None) -> bool:
    try:
        text.encode(encoding or "utf-8")
    except UnicodeEncodeError:
        return False
    return True


def _plain(value: Any) -> Any:
    """A value that JSON has: a number that is not finite is null, a path its text."""
    if isinstance(value, Mapping):
        return {str(name): _plain(entry) for name, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(entry) for entry in value]
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value

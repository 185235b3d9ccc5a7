"""Fence the `>>>` examples of docstrings, which Markdown would take for quotations."""

from __future__ import annotations

import re
from typing import Any

import griffe

EXAMPLE = re.compile(r"(?:^>>> .*\n?(?:^(?!>>> )\S.*\n?|^ .*\n?)*)+", re.MULTILINE)
"""Prompts and all lines below them up to an empty one."""


class Fence(griffe.Extension):
    """Put each example of a docstring into a block of code."""

    def on_object(self, *, obj: griffe.Object, **_: Any) -> None:
        """Rewrite the docstring of an object that has been read."""
        if obj.docstring and not obj.is_alias:
            obj.docstring.value = fence(obj.docstring.value)


def fence(text: str) -> str:
    """The text with a fence around each example."""
    return EXAMPLE.sub(lambda example: f"```pycon\n{example[0].rstrip()}\n```\n", text)

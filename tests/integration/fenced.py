"""The fenced code blocks of Markdown files, for tests that run what the documentation shows."""

import re
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


@dataclass(frozen=True)
class Block:
    """The text between two fences, its language, "" if none is named, and the line on which it starts, from 1."""

    language: str
    text: str
    line: int


def blocks(path: Path, *languages: str) -> list[Block]:
    """The blocks of a file in order, of these languages if any are named."""
    text = path.read_text(encoding="utf-8")
    fenced_blocks = [
        Block(match[1], match[2], text.count("\n", 0, match.start(2)) + 1)
        for match in re.finditer(r"^```(\w*)\n(.*?)^```$", text, flags=re.DOTALL | re.MULTILINE)
    ]
    return [block for block in fenced_blocks if not languages or block.language in languages]

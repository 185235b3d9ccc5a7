"""Templates and static files: data of this package, which decide how pages look. Loads nothing else. Ours."""

from __future__ import annotations

import hashlib
from pathlib import Path

TEMPLATES = Path(__file__).parent / "templates"
STATIC = Path(__file__).parent / "static"


def read_asset(name: str) -> str:
    """The text of a static file; raises FileNotFoundError.

    >>> read_asset("icon.svg").startswith("<svg")
    True
    """
    return (STATIC / name).read_text(encoding="utf-8")


def assets_digest() -> str:
    """SHA-256 in hex of the names and bytes of all templates and static files, which decide how pages look.

    >>> len(assets_digest())
    64
    """
    digest = hashlib.sha256()
    for path in sorted((*TEMPLATES.iterdir(), *STATIC.iterdir())):
        content = path.read_bytes()
        digest.update(f"{path.parent.name}/{path.name} {len(content)}\n".encode())
        digest.update(content)
    return digest.hexdigest()

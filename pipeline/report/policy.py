"""The content-security policy of a page: a browser runs and shows what it was written with, and nothing else. Ours.

Names of shapes, files and classes are anybody's. They are escaped; if one were not, its script would still not run.
"""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Sequence

FILES = ("'self'", "file:")
"""Where the files beside a page are: of its server, or in folders, which Firefox does not count as one origin."""


def policy(styles: Sequence[str], scripts: Sequence[str], *, files: bool = False) -> str:
    """The policy that admits these texts of ``<style>`` and ``<script>`` elements, and pictures within the page.

    With ``files`` it admits pictures and style sheets beside the page as well, and still no script from there. A policy
    is what a browser is told (https://www.w3.org/TR/CSP3/); an equal page has an equal one.

    >>> policy([], [])
    "default-src 'none'; img-src data:; base-uri 'none'; form-action 'none'"
    """
    beside = FILES if files else ()
    admitted = {
        "default-src": ("'none'",),
        "script-src": tuple(map(_hash, scripts)),
        "style-src": (*beside, *map(_hash, styles)),
        "img-src": (*beside, "data:"),
        "base-uri": ("'none'",),
        "form-action": ("'none'",),
    }
    return "; ".join(f"{name} {' '.join(sources)}" for name, sources in admitted.items() if sources)


def _hash(text: str) -> str:
    """A source that is this text and no other."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode('ascii')}'"

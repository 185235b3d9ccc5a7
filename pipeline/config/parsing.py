"""How values of a configuration are read that may be written in more than one way."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from pipeline.store.location import Location, Url


def parse_names(value: Any) -> Any:
    """Names as a list; one name may stand alone."""
    return [value] if isinstance(value, str) else value


def parse_pieces(value: Any) -> Any:
    """Numbers of pieces as a list: one number, ``3..5``, or a list of numbers."""
    if isinstance(value, str) and (ends := re.fullmatch(r"(\d+)\.\.(\d+)", value)):
        return list(range(int(ends[1]), int(ends[2]) + 1))
    return [value] if isinstance(value, int) else value


def parse_folder(value: Any, expected: str = "a path") -> Path:
    if isinstance(value, str | Path) and str(value) and "://" not in str(value):
        return Path(value).expanduser()
    raise ValueError(f"expected {expected}, got {value!r}")


def parse_address(value: Any) -> str:
    if isinstance(value, str) and (not value or value.startswith(("https://", "http://"))):
        return value and value.rstrip("/") + "/"
    raise ValueError(f"expected an address such as https://example.org/mpeg7/, got {value!r}")


def parse_location(value: Any) -> Location:
    return Url(value) if isinstance(value, str) and "://" in value else parse_folder(value, "a path or a URL")

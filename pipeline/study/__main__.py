"""Entry point: ``python -m pipeline.study NAME [+dataset=…] [name=value …]``, as `riot study`."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from pipeline.cli.main import run_command


def main(arguments: Sequence[str] | None = None) -> int:
    """Make one study; returns the exit code."""
    return run_command("study", "python -m pipeline.study", arguments)


if __name__ == "__main__":
    sys.exit(main())

"""Entry point: ``python -m pipeline.cache``, as `riot cache`; see `pipeline.cli.cache`."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from pipeline.cli.main import run_command


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    return run_command("cache", "python -m pipeline.cache", arguments)


if __name__ == "__main__":
    sys.exit(main())

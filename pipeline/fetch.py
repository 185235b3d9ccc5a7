"""Entry point: ``python -m pipeline.fetch``, as `riot fetch`; see `pipeline.cli.fetch`."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from pipeline.cli.main import run_command


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    return run_command("fetch", "python -m pipeline.fetch", arguments)


if __name__ == "__main__":
    sys.exit(main())

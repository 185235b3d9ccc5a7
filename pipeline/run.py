"""Entry point: ``python -m pipeline.run [+dataset=NAME] [name=value …] [--plan | --explain] [-m]``, as `riot mine`."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from pipeline.cli.main import run_command


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code of the run, of a sweep the worst one."""
    return run_command("mine", "python -m pipeline.run", arguments)


if __name__ == "__main__":
    sys.exit(main())

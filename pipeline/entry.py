"""Where the program ``riot`` begins: Ctrl-C while its modules load ends it as Ctrl-C does later. Ours."""

from __future__ import annotations

import importlib

from pipeline.exit_codes import INTERRUPTED


def main() -> int:
    """Run one command; returns its exit code.

    Loading the commands takes longer than all else that happens before one watches for Ctrl-C.
    """
    try:
        program = importlib.import_module("pipeline.cli.main")
    except KeyboardInterrupt:
        return INTERRUPTED
    code: int = program.main()
    return code

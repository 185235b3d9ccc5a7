"""A process that compiles: ``python -m riot.kernels.compiling.process`` reads names of modules, a line each.

It answers each with a line of JSON (`Answer`) when the module is compiled, and ends, whatever it is at, when its
standard input is closed: whoever started it has ended.
"""

from __future__ import annotations

import json
import os
import signal
import sys
import threading
import time
from dataclasses import asdict, dataclass
from queue import SimpleQueue

from riot.kernels.compiling.cache import compile_module


@dataclass(frozen=True)
class Answer:
    """The wall-clock seconds that a module took; ``failure`` tells why it is not in the cache, if it is not."""

    seconds: float
    failure: str = ""


def main() -> None:
    """Compile module after module."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # who started this process answers
    names: SimpleQueue[str] = SimpleQueue()
    threading.Thread(target=_read, args=(names,), daemon=True).start()
    while True:
        name, failure = names.get(), ""
        started = time.perf_counter()
        try:
            compile_module(name)
        except OSError as error:  # of a full disk, say
            failure = str(error)
        except Exception as error:
            failure = f"{type(error).__name__}: {error}"
        print(json.dumps(asdict(Answer(time.perf_counter() - started, failure))), flush=True)


def _read(names: SimpleQueue[str]) -> None:
    for line in sys.stdin:
        names.put(line.strip())
    os._exit(0)


if __name__ == "__main__":
    main()

"""Entry point: ``python -m pipeline.fetch``; see `pipeline.datasets.fetch`."""

import sys

from pipeline.datasets.fetch import main

if __name__ == "__main__":
    sys.exit(main())

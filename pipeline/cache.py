"""Entry point: ``python -m pipeline.cache``; see `pipeline.cli.cache`."""

import sys

from pipeline.cli.cache import main

if __name__ == "__main__":
    sys.exit(main())

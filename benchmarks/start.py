"""What a process pays for the digests of all stages, beside hashing the bytes of all source files.

``python benchmarks/start.py [--processes 5]`` starts processes that load the digests' modules, read the sources, and
take all stages' digests and library versions: with an empty cache of parsed files, and with a full one.
"""

from __future__ import annotations

import argparse
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from pipeline.stages.all import STAGES

ROOT = Path(__file__).resolve().parents[1]

DIGESTS = """
import sys, time
from pathlib import Path
began = time.process_time()
from pipeline.plan import code_digest
from pipeline.plan.closure import Project
from pipeline.plan.module_facts import FactsCache
from pipeline.plan.sources import AT_START, PACKAGES
cache = FactsCache(PACKAGES, Path(sys.argv[1]))
code_digest.PROJECT = Project(AT_START, cache)
for module in sys.argv[2:]:
    code_digest.code_digests(module)
    code_digest.library_versions(module)
print(time.process_time() - began)
"""

HASHES = """
import hashlib, time
from pathlib import Path
began = time.process_time()
for package in ("riot", "pipeline"):
    for path in Path(package).rglob("*.py"):
        hashlib.sha256(path.read_bytes()).digest()
print(time.process_time() - began)
"""


def cpu_seconds(code: str, *arguments: str) -> float:
    """CPU seconds that a fresh process prints."""
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments], cwd=ROOT, capture_output=True, text=True, check=True
    )
    return float(done.stdout)


def main() -> None:
    """Print the median of several processes each, and what the digests cost in units of hashing."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--processes", type=int, default=5, help="processes of each kind (default: 5)")
    count = parser.parse_args().processes
    modules = [stage.module for stage in STAGES]
    with tempfile.TemporaryDirectory() as folder:
        hashing = statistics.median(cpu_seconds(HASHES) for _ in range(count))
        cold = statistics.median(cpu_seconds(DIGESTS, f"{folder}/{number}.json", *modules) for number in range(count))
        warm = statistics.median(cpu_seconds(DIGESTS, f"{folder}/0.json", *modules) for _ in range(count))
    print(f"hashing all source files:  {hashing:.3f} CPU s")
    print(f"digests, nothing parsed:   {cold:.3f} CPU s, {cold / hashing:.1f} × hashing")
    print(f"digests, everything known: {warm:.3f} CPU s, {warm / hashing:.1f} × hashing")


if __name__ == "__main__":
    main()

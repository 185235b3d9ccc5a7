"""The studies by name, each with what it asks, and the names of the files that each writes into its folder.

A study is the module of its name in this package, with ``Parameters``, a dataclass with defaults, and ``study``, which
makes its findings of a finished run.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

STUDIES: Mapping[str, str] = MappingProxyType(
    {
        "consistency": "how far QCRS orders pairs as CRS does",
        "distributions": "how scores are spread, by class",
        "groundtruth": "whether hidden exact pairs are found",
        "parameters": "what the method's parameters do",
        "quiz": "pairs to judge, as the paper's people did",
        "recognition": "whether results are recognised",
        "sigmas": "what a greater σ_A of QCRS gains and costs",
        "timing": "what each step costs, beside the paper",
        "variety": "how much the first transforms show",
    }
)
"""The one list of studies; `pipeline/study/__init__.pyi` offers their modules."""

TABLE, PAGE = "table.parquet", "report.html"

TIMES = "times.parquet"
"""The file of times, which differ between equal runs; `TABLE` does not."""

LEAD = b"lead"
"""Key of the findings in a sentence or two, in the metadata of `TABLE`."""

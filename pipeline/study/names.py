"""The studies' names and what each asks, and the names of what each writes into its folder."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

MEANINGS: Mapping[str, str] = MappingProxyType(
    {
        "consistency": "how far QCRS orders pairs as CRS does",
        "distributions": "how scores are spread, by class",
        "groundtruth": "whether hidden exact pairs are found",
        "parameters": "what the method's parameters do",
        "quiz": "pairs to judge, as the paper's people did",
        "sigmas": "what a greater σ_A of QCRS gains and costs",
        "timing": "what each step costs, beside the paper",
    }
)
"""By the name of the module that has the study."""

TABLE, PAGE = "table.parquet", "report.html"

TIMES = "times.parquet"
"""What varies between equal runs, so that `TABLE` does not."""

LEAD = b"lead"
"""Key of the findings in a sentence or two, in the metadata of `TABLE`."""

"""What a run with ``qcrs.mode=topk`` says of its search: in the metadata of its table of pairs, and in words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields

import pyarrow as pa

from pipeline.tables import schemas as tables
from pipeline.tables.messages import several


@dataclass(frozen=True)
class PartnerSearch:
    """``k`` partners of each of ``shapes`` shapes; ``compared`` counts a pair once for each of the two looked up.

    ``missed`` shapes were not looked up everywhere, because that failed: the table may lack partners of theirs.
    """

    k: int
    shapes: int
    compared: int
    missed: int = 0

    @property
    def pairs(self) -> int:
        """All pairs of the shapes."""
        return self.shapes * (self.shapes - 1) // 2

    @property
    def meaning(self) -> str:
        """What the table has."""
        return f"every pair i < j of which one is among the {several(self.k, 'best partner')} of the other"

    def sentence(self, kept: int) -> str:
        """A sentence for the summary and the report."""
        missed = (
            f" Partners of {several(self.missed, 'shape')} could not be searched for everywhere." if self.missed else ""
        )
        return (
            f"qcrs.mode=topk: {kept:,} of {several(self.pairs, 'pair')} kept, {self.meaning}, and the selection saw "
            f"only these; of {2 * self.pairs:,} comparisons of a shape with another {self.compared:,} were made."
            + missed
        )

    def schema(self) -> pa.Schema:
        """The schema of `qcrs` with these numbers and another meaning in its metadata."""
        numbers = asdict(self)
        if not self.missed:
            del numbers["missed"]  # as a rule: the table of a search without failures says nothing of them
        encoded = {name.encode(): str(value).encode() for name, value in numbers.items()}
        meaning = f"Quick cross-reversibility score (paper §5.2) of {self.meaning} (ours).".encode()
        return tables.SCHEMAS["qcrs"].with_metadata({**tables.SCHEMAS["qcrs"].metadata, b"meaning": meaning, **encoded})


def read_search(metadata: Mapping[bytes, bytes] | None) -> PartnerSearch | None:
    """What `PartnerSearch.schema` wrote; None for the table of all pairs."""
    encoded = metadata or {}
    numbers = {
        field.name: int(encoded[field.name.encode()])
        for field in fields(PartnerSearch)
        if field.name.encode() in encoded
    }
    return PartnerSearch(**numbers) if {"k", "shapes", "compared"} <= numbers.keys() else None

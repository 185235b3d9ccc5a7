"""The figures of a search for partners, as metadata of the table of pairs and as a sentence."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields

from pipeline.tables import schemas as tables
from pipeline.tables.messages import several
from riot.errors import needs_extra

with needs_extra("mine"):
    import pyarrow as pa


@dataclass(frozen=True)
class PartnerSearch:
    """A search for the ``k`` best partners of each of ``shapes`` shapes.

    The search failed in some shards for ``missed`` shapes: the table may lack
    partners of them. ``approximate`` is 1 if it may lack some of any shape.
    """

    k: int
    shapes: int
    missed: int = 0
    approximate: int = 0

    @property
    def pairs(self) -> int:
        """All pairs of the shapes."""
        return self.shapes * (self.shapes - 1) // 2

    @property
    def meaning(self) -> str:
        """Which pairs the table has."""
        every = "nearly every" if self.approximate else "every"
        return f"{every} pair i < j of which one is among the {several(self.k, 'best partner')} of the other"

    def sentence(self, kept: int) -> str:
        """Describe the search for the summary and the report; ``kept`` is the number of rows of the table."""
        missed = (
            f" Partners of {several(self.missed, 'shape')} could not be searched for everywhere." if self.missed else ""
        )
        mode = "approximate" if self.approximate else "topk"
        return (
            f"qcrs.mode={mode}: {kept:,} of {several(self.pairs, 'pair')} kept, {self.meaning}, and the selection saw "
            f"only these.{missed}"
        )

    def schema(self) -> pa.Schema:
        """The schema of `qcrs` with these numbers and another meaning in its metadata."""
        numbers = asdict(self)
        always = ("k", "shapes")  # the metadata mention what is amiss only if it is
        encoded = {name.encode(): str(value).encode() for name, value in numbers.items() if value or name in always}
        meaning = f"Quick cross-reversibility score (paper §5.2) of {self.meaning} (ours).".encode()
        return tables.SCHEMAS["qcrs"].with_metadata({**tables.SCHEMAS["qcrs"].metadata, b"meaning": meaning, **encoded})


def read_search(metadata: Mapping[bytes, bytes] | None) -> PartnerSearch | None:
    """Undo `PartnerSearch.schema`; None for the metadata of a table of all pairs."""
    encoded = metadata or {}
    numbers = {
        field.name: int(encoded[field.name.encode()])
        for field in fields(PartnerSearch)
        if field.name.encode() in encoded
    }
    return PartnerSearch(**numbers) if {"k", "shapes"} <= numbers.keys() else None

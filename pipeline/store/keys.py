"""Content keys: what an artifact is named after, so that equal work is done once and changed work again.

A key is the SHA-256 of canonical JSON of the schema version, the stage's name, the parameters it reads, the digests of
its inputs, the digests of the code it runs and the versions of the libraries below it. Never a path, a time, a host,
the cluster or a logging setting.
"""

from __future__ import annotations

import dataclasses
import hashlib
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from pipeline.store.artifact import AnyArray, canonical_json

SCHEMA = 1
"""Version of the artifacts' layout and meaning; raising it makes every older artifact a miss."""


@dataclass(frozen=True)
class KeyParts:
    """Everything that a key depends on, kept beside the artifact so that a miss can be explained.

    ``shared`` may hold what many keys have in common, written out once; it changes no key.
    """

    stage: str
    parameters: Mapping[str, Any]
    inputs: tuple[str, ...]
    code: Mapping[str, str]
    versions: Mapping[str, str]
    schema: int = SCHEMA
    shared: SharedText | None = field(default=None, compare=False, repr=False)

    def to_json(self) -> dict[str, Any]:
        """The parts as JSON values."""
        return {
            "schema": self.schema,
            "stage": self.stage,
            "parameters": canonical_value(self.parameters),
            "inputs": list(self.inputs),
            "code": dict(self.code),
            "versions": dict(self.versions),
        }

    def each_input(self) -> Iterator[KeyParts]:
        """The same work on one input alone: what is done with a shape of a batch is named after this, not the batch."""
        return (replace(self, inputs=(name,)) for name in self.inputs)

    def key(self) -> str:
        """The content key: 64 hexadecimal digits."""
        return self._key

    @cached_property
    def _key(self) -> str:
        text = canonical_json(self.to_json()) if self.shared is None else self.shared.text(self.inputs)
        return digest_text(text)


@dataclass(frozen=True)
class SharedText:
    """Canonical JSON of key parts before and after their inputs: a collection's blocks differ in nothing else."""

    before: str
    after: str

    @classmethod
    def of(cls, parts: KeyParts) -> SharedText:
        """The text around the inputs of ``parts``."""
        values = parts.to_json()
        names = sorted(values)
        written = [f"{canonical_json(name)}:{canonical_json(values[name])}" for name in names]
        at = names.index("inputs")
        before = "{" + "".join(f"{text}," for text in written[:at]) + '"inputs":'
        return cls(before, "".join(f",{text}" for text in written[at + 1 :]) + "}")

    def text(self, inputs: Sequence[str]) -> str:
        """Canonical JSON of the whole, with these inputs."""
        return self.before + canonical_json(list(inputs)) + self.after


def digest_bytes(*pieces: bytes | memoryview) -> str:
    """SHA-256 of the pieces one after the other, in hexadecimal."""
    digest = hashlib.sha256()
    for piece in pieces:
        digest.update(piece)
    return digest.hexdigest()


def digest_text(text: str) -> str:
    """SHA-256 of the UTF-8 text, in hexadecimal."""
    return digest_bytes(text.encode())


def digest_array(array: AnyArray) -> str:
    """Digest of dtype, shape and values; memory layout, byte order, the sign of zero and NaN payloads do not count."""
    values = np.asarray(array)
    if values.dtype.kind not in "biufc":
        raise TypeError(f"cannot digest an array of {values.dtype}; give it numbers or booleans")
    shape = values.shape
    canonical = np.array(values, dtype=values.dtype.newbyteorder("<"), order="C", copy=True)
    if canonical.dtype.kind in "fc":
        parts = canonical.reshape(-1).view(canonical.real.dtype)
        parts[parts == 0] = 0.0
        parts[np.isnan(parts)] = np.nan
    head = canonical_json([canonical.dtype.str, list(shape)])
    return digest_bytes(head.encode() + b"\0" + canonical.tobytes())


def canonical_value(value: Any) -> Any:
    """JSON values of dataclasses, mappings, sequences, arrays and scalars, one form for each value.

    Raises TypeError for anything else, so that nothing enters a key by way of its ``repr``.
    """
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {f.name: canonical_value(getattr(value, f.name)) for f in dataclasses.fields(value)}
    if isinstance(value, np.ndarray):
        return {"array": digest_array(value)}
    if isinstance(value, np.generic):
        return canonical_value(value.item())
    if isinstance(value, Mapping):
        if not all(isinstance(name, str) for name in value):
            raise TypeError("a mapping in a key has names that are not text")
        return {name: canonical_value(item) for name, item in value.items()}
    if isinstance(value, tuple | list):
        return [canonical_value(item) for item in value]
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float):
        if not math.isfinite(value):
            return {"float": str(value)}
        return value + 0.0  # −0.0 becomes 0.0
    raise TypeError(f"cannot put a {type(value).__name__} into a key")

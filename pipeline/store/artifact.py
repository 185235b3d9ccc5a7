"""Artifact: named arrays and a small document, in one deterministic, memory-mappable payload.

Layout: 8 bytes magic, 8 bytes little-endian header length, a canonical JSON header (the document, and name, dtype,
shape, offset and length of every array), then the arrays' C-contiguous little-endian bytes, each at a multiple of 64.
No pickle anywhere: reading a payload runs no code.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from pipeline.errors import PayloadError

MAGIC = b"RIOTART1"
ALIGNMENT = 64
AnyArray = npt.NDArray[Any]


@dataclass(frozen=True, eq=False)
class Artifact:
    """What one work item produced: arrays by name, and a JSON document (rows, errors, scalars)."""

    arrays: Mapping[str, AnyArray] = field(default_factory=dict)
    document: Mapping[str, Any] = field(default_factory=dict)


def canonical_json(value: Any) -> str:
    """JSON with sorted keys and no spaces; floats in shortest round-trip form; NaN and infinity allowed."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"), ensure_ascii=False)


def encode(artifact: Artifact) -> bytes:
    """Serialise: equal artifacts give equal bytes, whatever the order of their names.

    Raises `PayloadError` for an array of objects or strings.
    """
    return b"".join(encode_pieces(artifact))


def encode_pieces(artifact: Artifact) -> list[bytes | memoryview]:
    """What `encode` joins; arrays are not copied, so that a large one is in memory once while it is written."""
    entries: list[dict[str, Any]] = []
    chunks: list[bytes | memoryview] = []
    position = 0
    for name in sorted(artifact.arrays):
        array = np.asarray(artifact.arrays[name])
        if array.dtype.kind not in "biuf":
            raise PayloadError(f"array {name!r} has dtype {array.dtype}; an artifact holds numbers and booleans only")
        shape = array.shape  # ascontiguousarray makes a scalar one-dimensional
        little = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<"))
        data = little.reshape(-1).view(np.uint8).data
        padding = -position % ALIGNMENT
        position += padding
        entries.append(
            {"name": name, "dtype": little.dtype.str, "shape": list(shape), "offset": position, "bytes": data.nbytes}
        )
        chunks += [b"\0" * padding, data]
        position += data.nbytes
    header = canonical_json({"arrays": entries, "document": artifact.document}).encode()
    start = len(MAGIC) + 8 + len(header)
    return [MAGIC, struct.pack("<Q", len(header)), header, b"\0" * (-start % ALIGNMENT), *chunks]


def decode(payload: bytes | memoryview) -> Artifact:
    """Read what `encode` wrote; the arrays are read-only views of ``payload``.

    Raises `PayloadError` when the bytes are not a whole payload.
    """
    view = memoryview(payload)
    try:
        if bytes(view[: len(MAGIC)]) != MAGIC:
            raise PayloadError("not an artifact: wrong magic bytes")
        (length,) = struct.unpack("<Q", view[len(MAGIC) : len(MAGIC) + 8])
        start = len(MAGIC) + 8 + length
        header = json.loads(bytes(view[len(MAGIC) + 8 : start]))
        start += -start % ALIGNMENT
        arrays: dict[str, AnyArray] = {}
        for entry in header["arrays"]:
            arrays[entry["name"]] = _read_array(entry, view[start:])
        if not isinstance(header["document"], dict):
            raise PayloadError("not a whole artifact: its document is no object")
        return Artifact(arrays, header["document"])
    except PayloadError:
        raise
    except (ValueError, KeyError, TypeError, OverflowError, RecursionError, struct.error) as error:
        raise PayloadError(f"not a whole artifact: {error}") from error


def _read_array(entry: Mapping[str, Any], data: memoryview) -> AnyArray:
    """An array of a payload whose arrays' bytes are ``data``, by its entry in the header, which may be anybody's."""
    offset, size, shape, dtype = entry["offset"], entry["bytes"], entry["shape"], np.dtype(entry["dtype"])
    if not all(type(number) is int and number >= 0 for number in (offset, size, *shape)):
        raise PayloadError("not a whole artifact: an offset, length or shape is no natural number")
    if dtype.kind not in "biuf" or offset + size > len(data):
        raise PayloadError(f"not a whole artifact: an array of {dtype} ends at byte {offset + size} of {len(data)}")
    array = np.frombuffer(data[offset : offset + size], dtype=dtype).reshape(shape)
    array.flags.writeable = False
    return array

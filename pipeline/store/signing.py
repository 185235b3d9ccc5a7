"""Signatures: who wrote an artifact, shown by a key that only the machines of a person or a group have. Ours.

A signature is the HMAC-SHA256 of a manifest, which names the digest of the payload. The key is read from a file on each
machine; what travels and what is printed is the name of that file.
"""

from __future__ import annotations

import hashlib
import hmac
import stat
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from pipeline.errors import SignatureError, StartError
from pipeline.store.location import Location
from riot.errors import needs_extra

with needs_extra("mine"):
    from platformdirs import user_config_path

USER = "user"
"""Stands for the key in the user's configuration."""

FILE = "store.key"
NAMED = 3
"""So many artifacts without a signature are named."""

LEAST_BYTES = 32
"""A key has as many bytes as the digest (RFC 2104, §3)."""


@dataclass(frozen=True)
class Signing:
    """The key of a file: a path, or `USER` = ``store.key`` in the user's configuration of riot, on each machine."""

    name: str

    @property
    def path(self) -> Path:
        """The file of the key on this machine."""
        if self.name == USER:
            return user_config_path("riot", appauthor=False) / FILE
        return Path(self.name).expanduser()

    @cached_property
    def _key(self) -> bytes:
        hint = f"make one with `openssl rand -hex 32 -out {self.path}` and `chmod 600 {self.path}`"
        try:
            mode = self.path.stat().st_mode
            key = self.path.read_bytes().strip()
        except OSError as error:
            raise StartError(f"sign={self.name}: no key in {self.path} ({error.strerror}); {hint}") from error
        if mode & stat.S_IROTH:
            raise StartError(f"sign={self.name}: everybody can read {self.path}; {hint}")
        if len(key) < LEAST_BYTES:
            raise StartError(f"sign={self.name}: {self.path} has less than {LEAST_BYTES} bytes; {hint}")
        return key

    def sign(self, text: str) -> str:
        """The signature of a text, in hexadecimal; raises `StartError` where there is no key."""
        return hmac.new(self._key, text.encode(), hashlib.sha256).hexdigest()

    def has_signed(self, text: str, signature: object) -> bool:
        """Whether a signature is that of the text."""
        return isinstance(signature, str) and hmac.compare_digest(self.sign(text).encode(), signature.encode())

    def error(self, location: Location, references: Sequence[tuple[str, str]]) -> SignatureError:
        """The error of artifacts, by stage and key, that are not signed with it."""
        named = ", ".join(f"{stage}/{key[:12]}" for stage, key in references[:NAMED])
        more = f" and {len(references) - NAMED} more" if len(references) > NAMED else ""
        return SignatureError(
            f"{location}: not signed with the key in {self.path}: {named}{more}. Somebody without that key may have "
            f"written this; choose another store, or delete what `riot cache verify --sign {self.name}` lists"
        )

    def __reduce__(self) -> tuple[type[Signing], tuple[str]]:
        return Signing, (self.name,)  # never with the key

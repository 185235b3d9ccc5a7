"""The errors of the pipeline; all are `riot.errors.RiotError`, each with a builtin parent as well."""

from __future__ import annotations

from riot.errors import RiotError


class PipelineError(RiotError):
    """Root of what the pipeline raises on purpose."""


class ConfigError(PipelineError, ValueError):
    """A name, type or value in the configuration that is not allowed; the message lists what is."""


class StartError(PipelineError, RuntimeError):
    """Something outside the configuration that keeps a run from starting (a folder that cannot be written …)."""


class StopError(PipelineError, RuntimeError):
    """What ends a run that had begun, of the machine or of the store; what is done is kept, and the run can go on."""


class StorageError(PipelineError, OSError):
    """A location that is full or read-only: no other file can be written there either."""


class PayloadError(PipelineError, ValueError):
    """Bytes that are no artifact, or an array that an artifact cannot hold."""


class SignatureError(PayloadError):
    """An artifact that is not signed with the reader's key: somebody else may have written it."""

"""Fabrication: from a transform to a puzzle in the hand (paper §4.4). All lengths in millimetres."""

from types import ModuleType
from typing import TYPE_CHECKING

from riot.lazy import offer

if TYPE_CHECKING:
    from riot.fabricate.offered import *  # noqa: F403


def _offered() -> ModuleType:
    import riot.fabricate.offered as module

    return module


offer(__name__, _offered, ("design",))

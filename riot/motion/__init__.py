"""Motion of a transform's pieces from P to Q without collision, as few hinges lifting as can be (theory §9)."""

from types import ModuleType
from typing import TYPE_CHECKING

from riot.lazy import offer

if TYPE_CHECKING:
    from riot.motion.offered import *  # noqa: F403


def _offered() -> ModuleType:
    import riot.motion.offered as module

    return module


offer(__name__, _offered)

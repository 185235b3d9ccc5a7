"""Plan how the pieces of a transform swing, when it is shown already."""

from __future__ import annotations

from msgspec import json

from riot.motion.planner import with_motion
from riot.transform.riot_file import to_json
from studio.scene import motion_scene
from studio.work.answer import Made
from studio.work.material import Files, transform


def plan_swing(files: Files, digest: str) -> Made:
    """The transform with its motion, under the digest that it has, and the motion's scene."""
    planned = with_motion(transform(files, digest))
    return Made(digest, to_json(planned).encode("utf-8"), json.encode(motion_scene(planned)))

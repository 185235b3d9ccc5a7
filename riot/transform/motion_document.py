"""A motion as plain values for the ``.riot`` file, and back, checked. Ours."""

from __future__ import annotations

from typing import Any

import numpy as np

from riot.transform.motion import SEARCHES, Attempt, Motion
from riot.transform.pose import Chain, Placement

ATTEMPT = ("first", "pieces", "search", "free", "checks")


def to_document(motion: Motion) -> dict[str, Any]:
    """A motion without what its transform holds already.

    >>> from riot.motion import plan_motion
    >>> sorted(to_document(plan_motion(transform)))[:3]
    ['gap', 'levels', 'lifted']
    """
    return {
        "open_hinge": motion.open_hinge,
        "lifted": list(motion.lifted),
        "search": motion.search,
        "times": motion.times.tolist(),
        "turns": motion.turns.tolist(),
        "levels": motion.levels.tolist(),
        "gap": motion.gap,
        "relief": motion.relief,
        "tried": [[getattr(attempt, name) for name in ATTEMPT] for attempt in motion.tried],
    }


def from_document(document: Any, chain: Chain, place_p: Placement, place_q: Placement) -> Motion:
    """Read what `to_document` wrote, for the transform with this chain; KeyError, TypeError, ValueError if damaged.

    >>> from riot.motion import plan_motion
    >>> motion = plan_motion(transform)
    >>> from_document(to_document(motion), transform.chain, transform.place_p, transform.place_q) == motion
    True
    """
    n = len(chain.lengths)
    times = _numbers(document["times"], "times", (-1,))
    turns = _numbers(document["turns"], "turns", (len(times), n))
    levels = _numbers(document["levels"], "levels", (len(times), n))
    cuts = [_whole(document["open_hinge"]), *map(_whole, document["lifted"])]
    search = str(document["search"])
    gap, relief = _numbers([document["gap"], document["relief"]], "gap and relief", (2,)).tolist()
    if len(times) < 2 or times[0] != 0.0 or times[-1] != 1.0 or (np.diff(times) <= 0.0).any():
        raise ValueError("the motion's times do not increase from 0 to 1")
    if len(set(cuts)) != len(cuts) or not set(cuts) <= set(range(n)):
        raise ValueError(f"the motion opens and lifts hinges {cuts} of {n}")
    if (levels != np.round(levels)).any() or levels.min() < 0 or search not in SEARCHES or min(gap, relief) < 0.0:
        raise ValueError(f"the motion's levels, search {search!r}, gap {gap} or relief {relief} make no sense")
    return Motion(
        open_hinge=cuts[0],
        lifted=tuple(cuts[1:]),
        search=search,
        times=times,
        turns=turns,
        levels=levels.astype(np.int64),
        gap=gap,
        relief=relief,
        tried=tuple(
            Attempt(_whole(first), _whole(pieces), str(name), bool(free), _whole(checks))
            for first, pieces, name, free, checks in document["tried"]
        ),
        chain=chain,
        place_p=place_p,
        place_q=place_q,
    )


def _whole(value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise TypeError(f"{value!r} where a whole number belongs")
    return value


def _numbers(value: Any, what: str, shape: tuple[int, ...]) -> Any:
    numbers = np.asarray(value, dtype=np.float64)
    expected = tuple(len(numbers) if size < 0 else size for size in shape)
    if numbers.shape != expected or not np.isfinite(numbers).all():
        raise ValueError(f"the motion's {what} have shape {numbers.shape} where finite numbers of {expected} belong")
    return numbers

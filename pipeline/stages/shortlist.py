"""The shortlist: of the pairs whose trunks were refined, the ones that are constructed (ours).

A construction reaches the bound of its trunks (theory §8), so that this ranks pairs by their true deformation.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from pipeline.stages.refine import bound
from pipeline.stages.select import Limits, greedy, labels
from pipeline.stages.specs import Refined
from pipeline.store.artifact import Artifact


def run(inputs: Sequence[Artifact], parameters: Sequence[Any], spec: Refined) -> Artifact:
    """Refined plans of the pairs, in order of selection → ``places`` (k,) among them, least deformation first.

    Greedily by falling bound, within the limits of ``select`` (policy ``paper`` has none); equal ones by place. Pairs
    without a plan are left out, unless there are too few others.
    """
    (settings,) = parameters
    bounds = np.array([bound(one) for one in inputs])
    order = np.argsort(-bounds, kind="stable")
    pairs = np.array(spec.pairs, dtype=np.int64).reshape(-1, 2)[order]
    if settings.policy == "paper":
        limits = Limits(settings.top, len(order) + 1, len(order) + 1)
    else:
        limits = Limits(settings.top, settings.per_class_pair, settings.per_shape)
    places = greedy(pairs[:, 0], pairs[:, 1], labels(spec.classes), limits)
    return Artifact({"places": order[np.array(places, dtype=np.int64)]})

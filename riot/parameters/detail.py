"""Parameters of the detail step of construction. All ours."""

from __future__ import annotations

from dataclasses import dataclass

from riot.parameters.field import ParameterGroup, parameter


@dataclass(frozen=True)
class DetailParameters(ParameterGroup):
    """The detail step (theory §8; all ours): how the tree's arcs follow the swung arcs beside them."""

    step: float = parameter(1 / 300, above=0, unit="L_c", meaning="Samples are at most this far apart.")
    feature: float = parameter(
        0.002,
        above=0,
        unit="L_c",
        meaning="Douglas–Peucker tolerance of the features of arcs, between which they correspond linearly.",
    )
    snap: float = parameter(
        0.02, at_least=0, unit="L_c", meaning="A junction goes to corners of the arcs that pass it within this length."
    )
    reach: float = parameter(
        0.1,
        above=0,
        unit="L_c",
        meaning="Length over which a displacement dies out where the two arcs are far apart, so that it costs no area.",
    )
    accuracy: tuple[float, ...] = parameter(
        (1.0, 0.1, 0.03, 0.015),
        unit="L_c",
        meaning="The same length where the two arcs agree: the weight of positions is the inverse of its fourth power. "
        "The first that loses little enough is taken; the shorter, the more a junction's displacement bends straight "
        "lines.",
    )
    agreement: float = parameter(0.005, above=0, unit="L_c", meaning="Arcs nearer to each other than this agree.")
    junction: float = parameter(
        0.005, at_least=0, unit="L_c", meaning="Junctions are moved at most this far from where the partition has them."
    )
    contract: float = parameter(
        0.00375,
        at_least=0,
        unit="L_c",
        meaning="Junctions with less tree than this between them are one: the partition cannot tell a cross from a "
        "short bar.",
    )
    max_loss: float = parameter(
        0.002,
        at_least=0,
        unit="areas",
        meaning="Detail may make this much more area change hands than the middle lines do, which lose least.",
    )
    max_share: float = parameter(
        0.08, at_least=0, meaning="Detail may make this share more area change hands than the middle lines do."
    )
    clearance: float = parameter(1e-6, above=0, unit="lengths", meaning="Arcs that come closer than this cross.")
    lines: int = parameter(256, at_least=1, meaning="Scanlines of the area that changes hands.")

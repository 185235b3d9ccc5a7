"""Parameters of bending the inputs before they are cut. All ours."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from riot.parameters.field import ParameterGroup, parameter


@dataclass(frozen=True)
class BendParameters(ParameterGroup):
    """Bending both inputs along their elastic modes, together with the trunks (theory §12; all ours)."""

    method: Literal["off", "elastic"] = parameter(
        "off", meaning="elastic: both shapes are bent a little before they are cut. off: they stay as they are."
    )
    starts: int = parameter(
        4,
        at_least=0,
        meaning="So many trunk pairs of each number of vertices from 3 to 8 are looked for too, best CRS first.",
    )
    modes: int = parameter(24, at_least=1, at_most=64, meaning="Elastic modes of each shape along which it may bend.")
    weight: float = parameter(
        1.0,
        at_least=0,
        meaning="Mean squared strain costs so much IoU: the greater, the less shapes bend.",
    )
    max_strain: float = parameter(
        0.35,
        above=0,
        below=1,
        meaning="Greatest stretch or squeeze anywhere in a shape, but for 0.2 % of its area.",
    )
    rms_strain: float = parameter(0.12, above=0, below=1, meaning="Greatest root mean square of the strain of a shape.")
    straight: float = parameter(
        1.0, at_least=0, meaning="Weight of straight sides and right angles that change, beside the strain; 0 for none."
    )
    contact: float = parameter(
        0.5,
        at_least=0,
        meaning="Weight of the squared shares of trunk edges that other pieces cover beyond half of what is allowed.",
    )
    sketched: int = parameter(4, at_least=1, meaning="So many of the most promising plans are bent a little.")
    sketch_steps: int = parameter(12, at_least=0, meaning="Most steps of trunks and bend together for that.")
    finished: int = parameter(2, at_least=0, meaning="So many of the best of these are bent to the end.")
    steps: int = parameter(48, at_least=0, meaning="Most steps for that.")
    turns: int = parameter(
        1, at_least=0, meaning="How often modes are computed anew on the bent shape, where it bends far."
    )
    judged: int = parameter(
        5, at_least=1, meaning="So many bent plans are constructed, and the one whose transform is worth most is kept."
    )
    limbs: float = parameter(
        0.1, at_least=0, meaning="Weight of the centre-line Dice beside the IoU where these are compared."
    )

"""Parameters of conjugate trunks and their refinement. All ours."""

from __future__ import annotations

from dataclasses import dataclass

from riot.parameters.field import ParameterGroup, parameter


@dataclass(frozen=True)
class RefineParameters(ParameterGroup):
    """Conjugate trunks and their refinement (theory §7; all ours)."""

    candidates: int = parameter(16, at_least=1, meaning="Trunk pairs tried for a pair of shapes, best CRS first.")
    sketched: int = parameter(
        16,
        at_least=0,
        meaning="So many of the most promising pairs are refined a little; 0 leaves the trunks where CRS has them.",
    )
    sketch_steps: int = parameter(16, at_least=0, meaning="Most steps of this first refinement.")
    refined: int = parameter(3, at_least=0, meaning="So many of the best of these are refined to the end.")
    steps: int = parameter(48, at_least=0, meaning="Most steps of the refinement to the end.")
    slide: float = parameter(
        0.25, above=0, unit="D_c", meaning="Refinement moves no trunk vertex farther than this along either axis."
    )
    reach: float = parameter(
        0.1, above=0, unit="L_c", meaning="Two arcs part at most this far along the outline from their trunk vertex."
    )
    attach: float = parameter(
        1.0,
        at_least=0,
        meaning="Weight of the squared distances of trunk vertices from the outline: off it the outlines get notches "
        "or spikes.",
    )
    lines: int = parameter(128, at_least=1, meaning="Scanlines of the IoU bound while trunks are refined.")
    bound_lines: int = parameter(512, at_least=1, meaning="Scanlines of the bound that plans are compared by.")

"""What `riot make` says of results that a person should look at, and what to do. Ours."""

from __future__ import annotations

from pathlib import Path

from riot.geometry.shape import Shape
from riot.transform.deformation import overlap_ratios
from riot.transform.transform import Transform


def doubtful_outline(path: Path, shape: Shape) -> list[str]:
    """What a user should know of the outline that was read from a file: why it may be wrong, if it may."""
    doubts = () if shape.quality is None else shape.quality.doubts
    return [
        f"{path}: the outline may be wrong: {doubt}. Look at it (`riot check FOLDER`), or mend the picture"
        for doubt in doubts
    ]


def poor_likeness(transform: Transform, least: float) -> str:
    """Say that a transform's shapes are not like its inputs, and what to do; ``least`` is the IoU that is asked for."""
    ious = zip((transform.p.name, transform.q.name), overlap_ratios(transform), strict=True)
    likeness = " and ".join(f"{iou:.2f} with {name}" for name, iou in ious)
    if transform.bend_p is None and transform.bend_q is None:
        advice = "Bend both shapes a little first (--bend), try"
    else:
        strains = (0.0 if bend is None else bend.rms_strain for bend in (transform.bend_p, transform.bend_q))
        likeness += f" as they are bent, by strains of {' and '.join(f'{strain:.1%}' for strain in strains)}"
        advice = "Try"
    return (
        f"poor likeness: the IoU is {likeness}, and --min-iou asks for {least:g}. These shapes do not turn well into "
        f"each other, so that people may not recognise them. {advice} another trunk pair (`riot trunks A B` lists "
        "them, --rank K takes one), or look for a better partner (`riot match A --in RUN`)"
    )

"""The parameters of a run as frozen groups that check themselves: the one home of defaults, ranges and meanings.

`pipeline.config.build` makes them of plain values; nothing below this package sees a DictConfig.
"""

from __future__ import annotations

import dataclasses
import typing
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from pipeline.config.cluster import ClusterConfig
from pipeline.config.parsing import parse_address, parse_folder, parse_location
from pipeline.config.selection import SelectConfig
from pipeline.datasets.collection import DatasetConfig
from pipeline.store.location import Location
from pipeline.store.signing import Signing
from riot.parameters import (
    QCRS_VARIANTS,
    BendParameters,
    ConstructParameters,
    ConvexityParameters,
    CrsParameters,
    FabricationParameters,
    LikenessParameters,
    MotionParameters,
    ParameterGroup,
    QcrsParameters,
    QcrsVariant,
    RefineParameters,
    ReversibilityParameters,
    ShapeParameters,
    TrunkParameters,
    parameter,
)


@dataclass(frozen=True)
class ShapeConfig(ShapeParameters):
    """Silhouette → shape, and what becomes of shapes that may have been read wrongly."""

    doubtful: Literal["drop", "keep"] = parameter(
        "drop",
        meaning="drop: shapes whose outlines may be wrong (column doubts of shapes) are left out of the selection. "
        "keep: they are taken as all others.",
    )

    @property
    def reading(self) -> ShapeParameters:
        """What pictures are read with."""
        names = (field.name for field in dataclasses.fields(ShapeParameters))
        return ShapeParameters(**{name: getattr(self, name) for name in names})


QcrsMode = Literal["all", "topk", "approximate"]


@dataclass(frozen=True)
class QcrsConfig(ParameterGroup):
    """Quick cross-reversibility score (paper §5.2): its trunks, its sigmas, and which pairs are scored."""

    variant: QcrsVariant = parameter(
        "paper",
        source="paper: paper §5.2; tuned: ours",
        meaning="paper: quick trunks are compared. tuned: the full trunks of CRS, to order pairs more as CRS does.",
    )
    sigma_e: float | None = parameter(
        None, above=0, unit="D_c", source="paper §5.2", meaning="Width of the edge term; null = the variant's own."
    )
    sigma_angle: float | None = parameter(
        None, above=0, unit="rad", source="paper §5.2", meaning="Width of the angle term; null = the variant's own."
    )
    sigma_area: float | None = parameter(
        None, above=0, unit="areas", source="paper §5.2", meaning="Width of the area term; null = the variant's own."
    )
    epsilon: float | None = parameter(
        None,
        at_least=0,
        unit="score in [0, 1]",
        source="ours",
        meaning="By how much a score may be too low, to be found sooner; null = the variant's own, 0: exact.",
    )
    mode: QcrsMode = parameter(
        "all",
        meaning="all: every pair is scored and tabulated. topk: only those among the k best partners of either shape, "
        "which an index finds. Both are exact. approximate: as topk, for less; about one pair in a hundred is missing.",
    )
    k: int = parameter(20, at_least=1, meaning="Partners of a shape (modes topk and approximate).")

    @property
    def sigmas(self) -> QcrsParameters:
        """The library's parameters alone: what enters the keys of scores."""
        variant = QCRS_VARIANTS[self.variant]
        given = {name: getattr(self, name) for name in (field.name for field in dataclasses.fields(variant))}
        return dataclasses.replace(variant, **{name: value for name, value in given.items() if value is not None})


@dataclass(frozen=True)
class BendConfig(BendParameters):
    """Bending the shapes that are constructed (theory §12; all ours). A run bends, the library only where asked to."""

    method: Literal["off", "elastic"] = parameter(
        "elastic", meaning="elastic: both shapes are bent a little before they are cut. off: they stay as they are."
    )


@dataclass(frozen=True)
class FabricateConfig(FabricationParameters):
    """Puzzles of the best transforms (paper §4.4): which are made, what is written, sizes and clearances."""

    top: int = parameter(
        0,
        at_least=0,
        meaning="So many of the least deformed certified transforms are made: about a second and a megabyte each.",
    )
    fix: bool = parameter(
        False,
        meaning="Thin the pin, enlarge the size or thicken knuckles of a puzzle that cannot be made as asked; the "
        "table names what was changed.",
    )
    paper: bool = parameter(
        False,
        meaning="Write laser files, an assembly page, pictures, and texture sheets of colour pictures too: some "
        "seconds each.",
    )

    @property
    def sizes(self) -> FabricationParameters:
        """The library's parameters alone: which transforms are made is no part of a puzzle's key."""
        names = (field.name for field in dataclasses.fields(FabricationParameters))
        return FabricationParameters(**{name: getattr(self, name) for name in names})


@dataclass(frozen=True)
class Config(ParameterGroup):
    """A whole run."""

    dataset: DatasetConfig
    outputs: Path = parameter(
        Path("outputs"), parse=parse_folder, meaning="Folder of tables and reports, which go to outputs/DATASET/."
    )
    store: Location = parameter(
        typing.cast("Location", Path("store")),
        parse=parse_location,
        meaning="Content-addressed artifacts, which all runs share: a folder, or a URL such as s3://bucket/prefix.",
    )
    sign: str | None = parameter(
        None,
        meaning="Sign what is written to the store, and take nothing from there that is not signed. user: with the key "
        "in store.key of the user's configuration of riot (~/.config/riot on Linux), on each machine. Else the file of "
        "a key. null: nothing is signed.",
    )
    address: str = parameter(
        "",
        parse=parse_address,
        meaning="Where outputs/DATASET/ will be published, such as https://example.org/mpeg7/: the pictures of link "
        "previews need it. Empty = nowhere.",
    )
    batch: int = parameter(
        32,
        at_least=1,
        unit="shapes",
        meaning="Mean size of a work item of the stages that take one shape; a QCRS block is a pair of such batches.",
    )
    compare: int = parameter(
        0,
        at_least=0,
        meaning="So many of the least deformed certified transforms are made by the paper's method too: about half a "
        "second each.",
    )
    shape: ShapeConfig = field(default_factory=ShapeConfig)
    reversibility: ReversibilityParameters = field(default_factory=ReversibilityParameters)
    convexity: ConvexityParameters = field(default_factory=ConvexityParameters)
    likeness: LikenessParameters = field(default_factory=LikenessParameters)
    trunks: TrunkParameters = field(default_factory=TrunkParameters)
    qcrs: QcrsConfig = field(default_factory=QcrsConfig)
    crs: CrsParameters = field(default_factory=CrsParameters)
    refine: RefineParameters = field(default_factory=RefineParameters)
    bend: BendConfig = field(default_factory=BendConfig)
    construct: ConstructParameters = field(default_factory=ConstructParameters)
    motion: MotionParameters = field(default_factory=MotionParameters)
    fabricate: FabricateConfig = field(default_factory=FabricateConfig)
    select: SelectConfig = field(default_factory=SelectConfig)
    cluster: ClusterConfig = field(default_factory=ClusterConfig)
    plan: bool = parameter(False, meaning="Show what would run, and stop.")
    explain: bool = parameter(False, meaning="Show why each work item would run, and stop.")
    profile: bool = parameter(False, meaning="Write profile.html, Dask's report of where the time goes.")

    @property
    def signing(self) -> Signing | None:
        """The key that artifacts are signed with, which stays in its file."""
        return None if self.sign is None else Signing(self.sign)

"""The parameters of a run as frozen groups that check themselves: the one home of defaults, ranges and meanings.

`pipeline.config.build` makes them of plain values; nothing below this package sees a DictConfig.
"""

from __future__ import annotations

import dataclasses
import re
import typing
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from pipeline.datasets.collection import DatasetConfig
from pipeline.store.location import Location, Url
from pipeline.store.signing import Signing
from riot.errors import ParameterError
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


BREADTH = {"varied": 20, "global": 10, "paper": 10}
"""How many times more pairs than ``top`` go on to CRS by each policy. Ours: with 20, 75 of 80 hidden pairs do."""


def _parse_names(value: Any) -> Any:
    """Names as a list; one name may stand alone."""
    return [value] if isinstance(value, str) else value


def _parse_pieces(value: Any) -> Any:
    """Numbers of pieces as a list: one number, ``3..5``, or a list of numbers."""
    if isinstance(value, str) and (ends := re.fullmatch(r"(\d+)\.\.(\d+)", value)):
        return list(range(int(ends[1]), int(ends[2]) + 1))
    return [value] if isinstance(value, int) else value


@dataclass(frozen=True)
class BendConfig(BendParameters):
    """Bending the shapes that are constructed (theory §12; all ours). A run bends, the library only where asked to."""

    method: Literal["off", "elastic"] = parameter(
        "elastic", meaning="elastic: both shapes are bent a little before they are cut. off: they stay as they are."
    )


@dataclass(frozen=True)
class SelectConfig(ParameterGroup):
    """Which pairs go on to CRS and construction, and which are chosen (policy paper: paper §5.3; else ours)."""

    policy: Literal["varied", "global", "paper"] = parameter(
        "varied",
        source="paper: paper §5.3; varied, global: ours",
        meaning="varied: many different things, each recognised well. global: the least deformed pairs of different "
        "classes. paper: all pairs among the shapes of best reversibility, one of each class.",
    )
    top: int = parameter(100, at_least=1, meaning="Number of pairs that are chosen.")
    per_class_pair: int = parameter(3, at_least=1, meaning="Most pairs of the same two classes (policy global).")
    per_shape: int = parameter(5, at_least=1, meaning="Most pairs with the same shape (policy global).")
    breadth: int | None = parameter(
        None,
        at_least=1,
        meaning="So many times more pairs, the best by QCRS, go on to CRS and refined trunks, with policy global "
        "within limits so many times wider; null = the policy's own: "
        f"{', '.join(f'{policy} {breadth}' for policy, breadth in BREADTH.items())}.",
    )
    pool: int = parameter(
        4,
        at_least=1,
        meaning="So many times more pairs than top are constructed, to choose from (policy varied).",
    )
    min_iou: float = parameter(
        0.9,
        at_least=0,
        at_most=1,
        meaning="Least IoU of the worse shape of a chosen pair; others are chosen only where too few have it (policy "
        "varied).",
    )
    min_surprise: float = parameter(
        0.0, at_least=0, meaning="Least surprise of a pair: how much its shapes differ (policy varied)."
    )
    classes: tuple[str, ...] = parameter(
        (), parse=_parse_names, meaning="Only pairs with a shape of one of these classes, such as [bird,fish]."
    )
    shapes: tuple[str, ...] = parameter((), parse=_parse_names, meaning="Only pairs with one of these shapes, by name.")
    exclude: tuple[str, ...] = parameter((), parse=_parse_names, meaning="No pair with one of these shapes or classes.")
    pieces: tuple[int, ...] = parameter(
        (), at_least=3, parse=_parse_pieces, meaning="Only so many pieces: 4, 3..5, or a list (policy varied)."
    )
    flat: bool = parameter(
        False,
        meaning="Only transforms that swing in one plane (policy varied).",
    )

    @property
    def breadth_of_policy(self) -> int:
        """``breadth``, or the policy's own."""
        return BREADTH[self.policy] if self.breadth is None else self.breadth

    @property
    def selected(self) -> int:
        """Most pairs that go on to CRS."""
        return self.breadth_of_policy * self.top

    @property
    def constructed(self) -> int:
        """Most pairs that are constructed."""
        return self.top * (min(self.pool, self.breadth_of_policy) if self.policy == "varied" else 1)

    def check_together(self) -> None:
        """Check that the policy heeds the wishes; raises `riot.errors.ParameterError`."""
        for name in ("pieces", "flat", "min_surprise"):
            if getattr(self, name) and self.policy != "varied":
                raise ParameterError(name, f"needs select.policy=varied; {self.policy} does not heed it")


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
class ClusterConfig(ParameterGroup):
    """Where the work runs, which changes no key and no result."""

    kind: Literal["local", "sync", "external", "slurm", "ssh", "kubernetes"] = parameter(
        "local",
        meaning="local: worker processes on this machine, one thread each. sync: this process, one work item after "
        "another. external: any Dask deployment whose workers see the store and the data set. slurm: jobs of Slurm. "
        "ssh: machines that SSH reaches. kubernetes: pods.",
    )
    workers: int | None = parameter(
        None,
        at_least=1,
        meaning="Worker processes: of local, null = one for each CPU; of each job of slurm or host of ssh, null = one; "
        "pods of kubernetes, null = one.",
    )
    minimum: int | None = parameter(
        None,
        at_least=1,
        meaning="Workers of local, or jobs of slurm, that stay when there is little to do: Dask scales from this to "
        "as many as there may be. null = all from the start to the end.",
    )
    address: str | None = parameter(None, meaning="Scheduler of external, such as tcp://host:8786.")
    wait: int = parameter(
        30,
        at_least=0,
        unit="s",
        meaning="How long external waits for the scheduler and its first worker, the others for their first worker.",
    )
    dashboard: bool = parameter(False, meaning="Serve Dask's dashboard (not external; extra dashboard).")
    limit: float | None = parameter(
        600.0,
        above=0,
        unit="s",
        meaning="A work item (a batch of shapes, a block of pairs, a pair) that takes longer is stopped and becomes an "
        "error; null = never. sync stops nothing.",
    )
    hosts: tuple[str, ...] = parameter(
        (),
        parse=_parse_names,
        meaning="Machines of ssh, such as a,b, as `ssh` knows them; the first one has the scheduler, too.",
    )
    python: str | None = parameter(
        None, meaning="The Python with riot on the machines of ssh; null = the path of the one that runs here."
    )
    image: str | None = parameter(None, meaning="The image of kubernetes; docker/Dockerfile makes one.")
    jobs: int = parameter(1, at_least=1, meaning="Jobs of slurm.")
    memory: str = parameter("4GB", meaning="Memory of a job of slurm for all its workers, of a pod of kubernetes.")
    walltime: str = parameter(
        "01:00:00", meaning="A job of slurm ends after this time, and another one replaces it; hours:minutes:seconds."
    )
    queue: str | None = parameter(None, meaning="Partition of slurm; null = the cluster's own choice.")
    account: str | None = parameter(None, meaning="Account of slurm; null = the cluster's own choice.")
    interface: str | None = parameter(
        None,
        meaning="Network interface by which scheduler and workers of slurm see one another, such as ib0; null = the "
        "machine's first.",
    )
    logs: str | None = parameter(
        None, meaning="Folder for what the jobs of slurm print; null = where the run was started."
    )
    options: tuple[str, ...] = parameter(
        (), meaning="Further options of sbatch, each in quotes, such as ['--qos=long','--exclusive']."
    )

    def check_together(self) -> None:
        """Check that a kind has what it needs; raises `riot.errors.ParameterError`."""
        if self.kind == "external" and not self.address:
            raise ParameterError("address", "cluster=external needs the scheduler's address, such as tcp://host:8786")
        if self.kind == "ssh" and not self.hosts:
            raise ParameterError("hosts", "cluster=ssh needs the machines, such as cluster.hosts=a,b")
        if self.kind == "kubernetes" and not self.image:
            raise ParameterError(
                "image", "cluster=kubernetes needs an image that has riot; docker/Dockerfile makes one"
            )
        if self.minimum is not None:
            most = {"local": self.workers, "slurm": self.jobs}
            if self.kind not in most:
                raise ParameterError("minimum", f"needs cluster=local or slurm; {self.kind} does not scale")
            if self.minimum > (most[self.kind] or self.minimum):
                raise ParameterError("minimum", f"is more than the {most[self.kind]} that there may be")


def _parse_folder(value: Any, expected: str = "a path") -> Path:
    if isinstance(value, str | Path) and str(value) and "://" not in str(value):
        return Path(value).expanduser()
    raise ValueError(f"expected {expected}, got {value!r}")


def _parse_address(value: Any) -> str:
    if isinstance(value, str) and (not value or value.startswith(("https://", "http://"))):
        return value and value.rstrip("/") + "/"
    raise ValueError(f"expected an address such as https://example.org/mpeg7/, got {value!r}")


def _parse_location(value: Any) -> Location:
    return Url(value) if isinstance(value, str) and "://" in value else _parse_folder(value, "a path or a URL")


@dataclass(frozen=True)
class Config(ParameterGroup):
    """A whole run."""

    dataset: DatasetConfig
    outputs: Path = parameter(
        Path("outputs"), parse=_parse_folder, meaning="Folder of tables and reports, which go to outputs/DATASET/."
    )
    store: Location = parameter(
        typing.cast("Location", Path("store")),
        parse=_parse_location,
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
        parse=_parse_address,
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

"""The configuration of a run as frozen, validated dataclasses; nothing below this module sees a DictConfig."""

from __future__ import annotations

import dataclasses
import difflib
import math
import types
import typing
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, TypeVar

from pipeline.datasets.collection import DatasetConfig
from pipeline.errors import ConfigError
from pipeline.store.location import Location, Url
from riot.parameters import (
    QCRS_VARIANTS,
    ConstructParameters,
    CrsParameters,
    FabricationParameters,
    MotionParameters,
    QcrsParameters,
    QcrsVariant,
    RefineParameters,
    ReversibilityParameters,
    ShapeParameters,
    TrunkParameters,
)

T = TypeVar("T")


@dataclass(frozen=True)
class QcrsConfig:
    """The quick scores' trunks and sigmas, which are all that a score depends on, and which pairs are scored (ours)."""

    variant: QcrsVariant = "paper"
    """``paper``: quick trunks. ``tuned``: the full trunks of CRS, to order pairs more as CRS does."""
    sigma_e: float | None = None
    """Of the edge term, in units of ``D_c``; null = the variant's, as of the others."""
    sigma_angle: float | None = None
    sigma_area: float | None = None

    mode: Literal["all", "topk"] = "all"
    """``all``: every pair. ``topk``: every shape's best partners, found through an index."""
    k: int = 20
    """Partners of a shape (``topk``)."""

    @property
    def sigmas(self) -> QcrsParameters:
        """The library's parameters alone: what enters the keys of scores."""
        usual = QCRS_VARIANTS[self.variant]
        given = {f.name: getattr(self, f.name) for f in dataclasses.fields(usual)}
        return dataclasses.replace(usual, **{name: value for name, value in given.items() if value is not None})


@dataclass(frozen=True)
class SelectConfig:
    """Which pairs go on to CRS and construction (paper §5.3 for ``paper``; ``global`` is ours)."""

    policy: Literal["paper", "global"] = "global"
    """``paper``: the shape of best reversibility of each class, all pairs among them. ``global``: over all pairs."""
    top: int = 100
    """Number of pairs that are constructed."""
    per_class_pair: int = 3
    """At most so many of them of the same two classes (``global``)."""
    per_shape: int = 5
    """At most so many of them with the same shape (``global``)."""
    breadth: int = 10
    """So many times more pairs, by QCRS and within limits so many times wider, go on to CRS and refined trunks; of
    these the ones whose trunks allow the least deformation are constructed."""


@dataclass(frozen=True)
class FabricateConfig(FabricationParameters):
    """Puzzles of the best transforms: sizes and clearances in mm, which of them are made, and what is written."""

    top: int = 0
    """So many of the least deformed certified transforms are made."""
    fix: bool = False
    """Thin the pin, enlarge the size or thicken knuckles of a puzzle that cannot be made as asked."""
    paper: bool = False
    """Write laser files, an assembly page and pictures too."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.top < 0:
            raise ValueError(f"top: must be 0 or more, got {self.top}")

    @property
    def sizes(self) -> FabricationParameters:
        """The library's parameters alone: which transforms are made is no part of a puzzle's key."""
        return FabricationParameters(
            **{f.name: getattr(self, f.name) for f in dataclasses.fields(FabricationParameters)}
        )


@dataclass(frozen=True)
class ClusterConfig:
    """Where the work runs; never part of a key."""

    kind: Literal["local", "sync", "external", "slurm"] = "local"
    workers: int | None = None
    """Worker processes of ``local``, null = one for each CPU; of each job of ``slurm``, null = one."""
    address: str | None = None
    """Scheduler of ``external``, such as tcp://host:8786."""
    wait: int = 30
    """Seconds that ``external`` waits for the scheduler and its first worker, ``slurm`` for its first job."""
    dashboard: bool = False
    """Serve Dask's dashboard (``local``, ``slurm``)."""
    limit: float | None = 600.0
    """Seconds after which a work item (a batch of shapes, a block of pairs, a pair) is stopped and becomes an error;
    null = never. It changes no key, and no result but the errors. There is none in ``sync``."""
    jobs: int = 1
    """Slurm jobs; this and all that follows is for ``slurm``."""
    memory: str = "4GB"
    """Of a job, for all its workers."""
    walltime: str = "01:00:00"
    """After which a job ends, and another takes its place."""
    queue: str | None = None
    """Partition; null = the cluster's own choice, as of the account."""
    account: str | None = None
    interface: str | None = None
    """Network interface by which scheduler and workers see one another, such as ib0; null = the machine's first."""
    logs: str | None = None
    """Folder for what the jobs print; null = where the run was started."""
    options: tuple[str, ...] = ()
    """Further options of sbatch, each in quotes: ``cluster.options=['--qos=long','--exclusive']``."""


@dataclass(frozen=True)
class Config:
    """A whole run."""

    dataset: DatasetConfig
    outputs: Path = Path("outputs")
    """Tables and report go to ``outputs/<dataset>/``."""
    store: Location = Path("store")
    """Content-addressed artifacts, shared by all runs: a folder, or a URL such as s3://bucket/prefix."""
    batch: int = 32
    """Mean number of shapes in a work item of the per-shape stages; a QCRS block is a pair of batches."""
    compare: int = 0
    """So many of the least deformed certified transforms are made by the paper's method too."""
    shape: ShapeParameters = field(default_factory=ShapeParameters)
    reversibility: ReversibilityParameters = field(default_factory=ReversibilityParameters)
    trunks: TrunkParameters = field(default_factory=TrunkParameters)
    qcrs: QcrsConfig = field(default_factory=QcrsConfig)
    crs: CrsParameters = field(default_factory=CrsParameters)
    refine: RefineParameters = field(default_factory=RefineParameters)
    construct: ConstructParameters = field(default_factory=ConstructParameters)
    motion: MotionParameters = field(default_factory=MotionParameters)
    fabricate: FabricateConfig = field(default_factory=FabricateConfig)
    select: SelectConfig = field(default_factory=SelectConfig)
    cluster: ClusterConfig = field(default_factory=ClusterConfig)
    plan: bool = False
    """Show what would run, and stop."""
    explain: bool = False
    """Show why each work item would run, and stop."""


# Bounds of values by "group.name", where "greater than 0" (sigmas, tolerances, counts) does not say it.
_MAY_BE_ZERO = frozenset(
    {
        "trunks.min_area",
        "trunks.min_congruent",
        "trunks.max_overlap",
        "trunks.neck_width",
        "trunks.tau_c",
        "trunks.min_inside",
        "trunks.sparse_tolerance",
        "shape.feature_tolerance",
        "shape.vertex_tolerance",
        "shape.smoothing",
        "reversibility.simplify",
        "construct.tolerance",
        "construct.max_cut_off",
        "construct.max_lost_contact",
        "construct.snap",
        "refine.sketched",
        "refine.sketch_steps",
        "refine.refined",
        "refine.steps",
        "refine.attach",
    }
)
_AT_MOST_ONE = frozenset({"trunks.tau_c", "trunks.min_inside", "trunks.max_arc", "trunks.min_area"})
_STAGE_GROUPS = frozenset({"shape", "reversibility", "trunks", "qcrs", "crs", "refine", "construct", "select"})


def make_config(values: Mapping[str, Any]) -> Config:
    """Build the typed configuration from plain values (nested mappings, as Hydra composes them).

    Raises `ConfigError` for an unknown name, a wrong type or a value out of range; the message says which are allowed.
    """
    config = build(Config, values)
    _check_ranges(config)
    if config.cluster.kind == "external" and not config.cluster.address:
        raise ConfigError("cluster.address: cluster=external needs the scheduler's address, such as tcp://host:8786")
    if config.reversibility.waist_low >= config.reversibility.waist_high:
        raise ConfigError("reversibility.waist_low: must be less than reversibility.waist_high")
    if config.trunks.max_vertices < 3:
        raise ConfigError("trunks.max_vertices: a trunk has at least 3 vertices")
    return config


def build(cls: type[T], values: Mapping[str, Any], where: str = "") -> T:
    """Fill the dataclass ``cls`` from ``values``, checking every name and type; ``where`` prefixes messages."""
    hints = typing.get_type_hints(cls)
    fields = {f.name: f for f in dataclasses.fields(cls)}  # type: ignore[arg-type]
    unknown = sorted(str(name) for name in set(values) - set(fields))
    if unknown:
        raise ConfigError(unknown_name(where + unknown[0], [where + name for name in fields]))
    filled = {name: _convert(hints[name], value, where + name) for name, value in values.items()}
    missing = [
        where + f.name
        for f in fields.values()
        if f.name not in filled and f.default is dataclasses.MISSING and f.default_factory is dataclasses.MISSING
    ]
    if missing:
        raise ConfigError(f"{missing[0]}: a value is needed; give {missing[0]}=…")
    try:
        return cls(**filled)
    except ConfigError:
        raise
    except ValueError as error:  # a dataclass that checks itself, and names its field first
        raise ConfigError(f"{where}{error}") from error


def unknown_name(name: str, allowed: list[str]) -> str:
    """The message for a name that does not exist: the nearest ones, and all of them."""
    near = difflib.get_close_matches(name, allowed, n=1)
    hint = f" Did you mean {near[0]}?" if near else ""
    return f"{name}: no such parameter.{hint} Allowed: {', '.join(sorted(allowed))}"


def _convert(hint: Any, value: Any, where: str) -> Any:
    origin = typing.get_origin(hint)
    if origin in (typing.Union, types.UnionType):
        return _convert_union(typing.get_args(hint), value, where)
    if origin is Literal:
        allowed = typing.get_args(hint)
        if value not in allowed or isinstance(value, bool):
            raise ConfigError(f"{where}: {value!r} is not allowed; choose one of {', '.join(map(str, allowed))}")
        return value
    if origin is tuple:
        if not isinstance(value, list | tuple):
            raise ConfigError(f"{where}: expected a list such as [a,b], got {value!r}")
        return tuple(_convert(typing.get_args(hint)[0], one, f"{where}[{place}]") for place, one in enumerate(value))
    if dataclasses.is_dataclass(hint):
        if not isinstance(value, Mapping):
            raise ConfigError(f"{where}: expected a group of parameters, got {value!r}")
        return build(typing.cast("type[Any]", hint), value, where + ".")
    if hint is Path and isinstance(value, str | Path) and str(value) and "://" not in str(value):
        return Path(value).expanduser()
    if hint is Url and isinstance(value, str) and "://" in value:
        return Url(value)
    if hint is float and isinstance(value, int | float) and not isinstance(value, bool):
        if not math.isfinite(value):
            raise ConfigError(f"{where}: {value} is not a finite number")
        return float(value)
    if hint is int and isinstance(value, int) and not isinstance(value, bool):
        return value
    if hint in (bool, str) and isinstance(value, hint):
        return value
    if hint is type(None) and value is None:
        return None
    raise ConfigError(f"{where}: expected {_describe(hint)}, got {value!r}")


def _convert_union(options: tuple[Any, ...], value: Any, where: str) -> Any:
    if value is None and type(None) in options:
        return None
    failures: list[ConfigError] = []
    for option in options:
        if option is type(None):
            continue
        try:
            return _convert(option, value, where)
        except ConfigError as error:
            failures.append(error)
    if len(failures) == 1:
        raise failures[0]
    expected = " or ".join(_describe(option) for option in options)
    raise ConfigError(f"{where}: expected {expected}, got {value!r}")


def _describe(hint: Any) -> str:
    names = {float: "a number", int: "a whole number", bool: "true or false", str: "text", Path: "a path", Url: "a URL"}
    if hint is type(None):
        return "null"
    return names.get(hint, getattr(hint, "__name__", str(hint)))


def _check_ranges(config: Config) -> None:
    if config.batch < 1:
        raise ConfigError(f"batch: must be 1 or more, got {config.batch}")
    if config.compare < 0:
        raise ConfigError(f"compare: must be 0 or more, got {config.compare}")
    if config.cluster.workers is not None and config.cluster.workers < 1:
        raise ConfigError(f"cluster.workers: must be 1 or more, or null, got {config.cluster.workers}")
    if config.cluster.jobs < 1:
        raise ConfigError(f"cluster.jobs: must be 1 or more, got {config.cluster.jobs}")
    if config.cluster.limit is not None and config.cluster.limit <= 0.0:
        raise ConfigError(f"cluster.limit: must be greater than 0, or null, got {config.cluster.limit}")
    for group in sorted(_STAGE_GROUPS):
        parameters = getattr(config, group)
        for f in dataclasses.fields(parameters):
            where, value = f"{group}.{f.name}", getattr(parameters, f.name)
            if isinstance(value, bool) or not isinstance(value, int | float):
                continue
            if value < 0 or (value == 0 and where not in _MAY_BE_ZERO):
                bound = "0 or more" if where in _MAY_BE_ZERO else "greater than 0"
                raise ConfigError(f"{where}: must be {bound}, got {value}")
            if value > 1 and where in _AT_MOST_ONE:
                raise ConfigError(f"{where}: must be at most 1, got {value}")

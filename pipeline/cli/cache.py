"""The commands `riot cache du|verify|gc|accept`: measure, check and tidy the store.

``accept`` keeps a run's artifacts after an edit of the code that changes no result.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path

from pipeline.cli.accept import accept, parts_of
from pipeline.errors import PayloadError, StartError
from pipeline.exit_codes import CLEAN
from pipeline.plan.code_digest import code_digests, library_versions
from pipeline.stages.all import STAGES
from pipeline.store.keys import SCHEMA, KeyParts
from pipeline.store.location import parse_location
from pipeline.store.signing import Signing
from pipeline.store.store import State, Store, folder_name
from pipeline.tables.messages import several
from pipeline.tables.record import ARTIFACTS
from riot.cli.output import Output
from riot.cli.parser import EXIT_CODES, Parser
from riot.cli.table import Table

DAMAGED = 3
"""Exit code of ``verify`` when it finds damage."""

WORDS = {**dict.fromkeys(State, "corrupt or not committed"), State.UNSIGNED: "not signed"}


@dataclass(frozen=True)
class Usage:
    """The artifacts of a stage in the store."""

    stage: str
    artifacts: int
    size: int
    """Bytes of all its files."""
    stale: int
    stale_size: int
    """Bytes of its stale artifacts (see `stale`)."""


def usage(store: Store) -> list[Usage]:
    """Artifacts and bytes by stage."""
    old = stale(store)
    sizes_by_stage: dict[str, list[tuple[int, bool]]] = {}
    for stage, key in store.folders():
        size = sum(store.files.sizes(folder_name(stage, key)).values())
        sizes_by_stage.setdefault(stage, []).append((size, (stage, key) in old))
    return [
        Usage(stage, len(sizes), sum(size for size, _ in sizes), sum(old for _, old in sizes),
              sum(size for size, old in sizes if old))
        for stage, sizes in sorted(sizes_by_stage.items())
    ]  # fmt: skip


def stale(store: Store) -> set[tuple[str, str]]:
    """(stage, key) of every artifact that was made by other code or libraries than are here, or from such an artifact.

    No run with this code reads them, whatever its parameters and pictures. A damaged manifest counts as stale.
    """
    references: set[tuple[str, str]] = set()
    names: set[str] = set()  # keys of stale artifacts, and of the single shapes in them
    makers = {**{stage.name: stage.module for stage in STAGES}, "index": "pipeline.match.index"}
    for stage in dict.fromkeys((*makers, *store.files.names(""))):
        module = makers.get(stage)
        here = (code_digests(module), library_versions(module), SCHEMA) if module else None
        for _, key in store.folders(stage):
            parts = _parts(store, stage, key)
            as_here = parts is not None and (parts.code, parts.versions, parts.schema) == here
            if parts is not None and as_here and names.isdisjoint(parts.inputs):
                continue
            references.add((stage, key))
            names.add(key)
            if parts is not None and stage == "ingest":
                names.update(alone.key() for alone in parts.each_input())
    return references


def _parts(store: Store, stage: str, key: str) -> KeyParts | None:
    try:
        entry = store.entry(stage, key)
    except (PayloadError, OSError):
        return None
    return None if entry is None else parts_of(entry)


def damaged(store: Store) -> dict[tuple[str, str], State]:
    """State of every artifact, by (stage, key), whose bytes are not those that were written, or not signed."""
    states = {(stage, key): store.state(stage, key) for stage, key in store.folders()}
    return {name: state for name, state in states.items() if state is not State.PRESENT}


def needed(outputs: Path) -> tuple[set[tuple[str, str]], int]:
    """(stage, key) of every artifact that the runs below ``outputs`` need, and the number of those runs.

    Raises `StartError` if the list of a run cannot be read.
    """
    keys: set[tuple[str, str]] = set()
    runs = sorted(outputs.rglob(ARTIFACTS)) if outputs.is_dir() else []
    for file in runs:
        for stage, names in _keys_of_run(file).items():
            keys.update((stage, name) for name in names)
    return keys, len(runs)


def garbage(store: Store, keep: set[tuple[str, str]]) -> Iterator[str]:
    """The folders of artifacts that are damaged or not in ``keep``, and abandoned temporary files, by name."""
    yield from store.files.abandoned("")
    for stage, key in store.folders():
        folder = folder_name(stage, key)
        if (stage, key) not in keep or store.state(stage, key) is not State.PRESENT:
            yield folder
        else:
            yield from (f"{folder}/{name}" for name in store.files.abandoned(folder))


@dataclass(frozen=True)
class CacheCommand:
    """A command on a store: further options, what it does, and exit codes of its own."""

    work: Callable[[Store, argparse.Namespace, Output], int]
    more: Callable[[Parser], None] = lambda parser: None
    exit_codes: Mapping[int, str] = field(default_factory=dict)

    def add_options(self, parser: Parser) -> None:
        """See `riot.cli.command.CommandModule`."""
        parser.add_argument(
            "--store",
            type=parse_location,
            default=Path("store"),
            metavar="LOCATION",
            help="folder or URL (default: store)",
        )
        parser.add_argument(
            "--sign",
            metavar="KEY",
            help="user, or the file of a key, as in sign=KEY of a run: what is not signed with it counts as damaged",
        )
        self.more(parser)
        parser.exit_codes = {**EXIT_CODES, **self.exit_codes}

    def run(self, chosen: argparse.Namespace, output: Output) -> int:
        """See `riot.cli.command.CommandModule`; raises `StartError` if there is no store."""
        store = Store(chosen.store, None if chosen.sign is None else Signing(chosen.sign))
        if not store.files.exists():
            raise StartError(f"{store.root}: there is no store here; give --store LOCATION")
        return self.work(store, chosen, output)


def _du(store: Store, chosen: argparse.Namespace, output: Output) -> int:
    usages = usage(store)
    sums = (sum(getattr(row, name) for row in usages) for name in ("artifacts", "size", "stale", "stale_size"))
    rows = [
        (row.stage, f"{row.artifacts:,}", f"{row.size / 1e6:,.1f}", f"{row.stale:,}", f"{row.stale_size / 1e6:,.1f}")
        for row in (*usages, Usage("all", *sums))
    ]
    table = Table(("stage", "artifacts", "MB", "stale", "stale MB"), rows, left=("stage",), totals=1)
    facts = {"store": str(store.root), "stages": [asdict(row) for row in usages]}
    output.facts(facts, table, "Stale: made by other code or libraries than are here, or from what was.")
    return CLEAN


def _verify(store: Store, chosen: argparse.Namespace, output: Output) -> int:
    states = {f"{stage}/{key}": state for (stage, key), state in damaged(store).items()}
    references = list(states)
    total = sum(1 for _ in store.folders())
    counted = f"{several(total, 'artifact')}, {len(references)} damaged"
    facts = {"store": str(store.root), "artifacts": total, "damaged": references}
    output.facts(
        facts,
        *(f"{WORDS[state]}: {reference}" for reference, state in states.items()),
        f"{counted}; the next run makes them again" if references else counted,
    )
    return DAMAGED if references else CLEAN


def _gc(store: Store, chosen: argparse.Namespace, output: Output) -> int:
    with store.files.alone() as alone:
        return _collect_garbage(store, chosen, alone, output)


def _collect_garbage(store: Store, options: argparse.Namespace, alone: bool, output: Output) -> int:
    keep, runs = needed(options.outputs)
    if options.stale:
        keep -= stale(store)
    if runs == 0:
        raise StartError(
            f"{options.outputs}: no finished run here names what it needs, so that everything would go; "
            f"give --outputs DIR, or delete {store.root} yourself"
        )
    if not (alone or options.alone or options.dry_run):
        raise StartError(
            f"{store.root}: a run is using it, or it cannot be known whether one is, and what that has done so far "
            "would go; wait until it has ended, or give --alone if there is none"
        )
    count = size = 0
    for name in list(garbage(store, keep)):
        count += 1
        folder, _, file = name.rpartition("/")
        size += sum(store.files.sizes(name).values()) or store.files.sizes(folder).get(file, 0)
        if not options.dry_run:
            store.files.remove(name)
    verb = "would be deleted" if options.dry_run else "deleted"
    what = several(count, "artifact or left-over file", "artifacts or left-over files")
    keeping = several(runs, "run keeps", "runs keep")
    facts = {"store": str(store.root), "removed": count, "bytes": size, "runs": runs, "kept": len(keep)}
    output.facts(
        {**facts, "dry_run": options.dry_run},
        f"{what}, {size / 1e6:,.1f} MB, {verb}; {keeping} {several(len(keep), 'artifact')}",
    )
    return CLEAN


def _accept(store: Store, chosen: argparse.Namespace, output: Output) -> int:
    run = chosen.run_folder
    try:
        acceptance = accept(store, _keys_of_run(run / ARTIFACTS), dry_run=chosen.dry_run)
    except (KeyError, PayloadError) as error:
        reason = error.args[0] if isinstance(error, KeyError) else error
        raise StartError(
            f"{store.root}: not all that {run} stands on is whole ({reason}); run it again instead"
        ) from error
    verb = "would be accepted" if chosen.dry_run else "accepted"
    total = sum(acceptance.accepted.values())
    facts = {"store": str(store.root), "accepted": dict(acceptance.accepted), "changes": dict(acceptance.changes)}
    output.facts(
        {**facts, "dry_run": chosen.dry_run},
        *(f"  {count} × {text}" for text, count in sorted(acceptance.changes.items())),
        f"{several(total, 'artifact')} {verb} as what the code and libraries here would compute",
    )
    return CLEAN


def _keys_of_run(file: Path) -> dict[str, list[str]]:
    try:
        keys = json.loads(file.read_bytes())
        return {str(stage): [str(key) for key in names] for stage, names in keys.items()}
    except (OSError, ValueError, TypeError, AttributeError) as error:
        raise StartError(
            f"{file}: cannot be read ({error}); run again, or remove the run's folder if it is not needed"
        ) from error


def _gc_options(parser: Parser) -> None:
    parser.add_argument(
        "--outputs", type=Path, default=Path("outputs"), metavar="DIR", help="runs to keep for (default: outputs)"
    )
    parser.add_argument(
        "--stale", action="store_true", help="also what finished runs need of other code or libraries than are here"
    )
    parser.add_argument("--alone", action="store_true", help="no run is using the store: it cannot be known")
    _dry_run_option(parser)


def _accept_options(parser: Parser) -> None:
    parser.add_argument(
        "--run", dest="run_folder", type=Path, required=True, metavar="RUN", help="folder of the run, as outputs/mpeg7"
    )
    _dry_run_option(parser)


def _dry_run_option(parser: Parser) -> None:
    parser.add_argument("--dry-run", action="store_true", help="say what would be done, do nothing")


DU = CacheCommand(_du)
VERIFY = CacheCommand(_verify, exit_codes={DAMAGED: "Some artifacts are damaged."})
GC = CacheCommand(_gc, _gc_options)
ACCEPT = CacheCommand(_accept, _accept_options)

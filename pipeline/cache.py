"""``python -m pipeline.cache du|verify|gc``: what the store holds, whether it is whole, and what no run needs."""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from rich.table import Table

from pipeline.errors import StartError
from pipeline.record import ARTIFACTS
from pipeline.remarks import several
from pipeline.store import TEMPORARY, State, Store

STALE_SECONDS = 3600.0
"""A temporary file this old belongs to no writer any more."""

OK, DAMAGED, BAD_START = 0, 3, 2


@dataclass(frozen=True)
class Usage:
    """What a stage takes in the store."""

    stage: str
    artifacts: int
    size: int
    """Bytes of all its files."""


def usage(store: Store) -> list[Usage]:
    """Artifacts and bytes by stage."""
    found: dict[str, list[int]] = {}
    for stage, key in store.folders():
        files = [file for file in store.folder(stage, key).iterdir() if file.is_file()]
        found.setdefault(stage, []).append(sum(file.stat().st_size for file in files))
    return [Usage(stage, len(sizes), sum(sizes)) for stage, sizes in sorted(found.items())]


def damaged(store: Store) -> list[tuple[str, str]]:
    """(stage, key) of every artifact that is not whole, down to the last byte."""
    return [(stage, key) for stage, key in store.folders() if store.state(stage, key) is not State.PRESENT]


def needed(outputs: Path) -> tuple[set[tuple[str, str]], int]:
    """(stage, key) of every artifact that a run below ``outputs`` stands on, and the number of those runs.

    Raises `StartError` for a run whose list cannot be read: what it needs is not known.
    """
    keys: set[tuple[str, str]] = set()
    runs = sorted(outputs.rglob(ARTIFACTS)) if outputs.is_dir() else []
    for file in runs:
        try:
            for stage, names in json.loads(file.read_bytes()).items():
                keys.update((stage, name) for name in names)
        except (OSError, ValueError, TypeError, AttributeError) as error:
            raise StartError(
                f"{file}: cannot be read ({error}); run again, or remove the run's folder if it is not needed"
            ) from error
    return keys, len(runs)


def garbage(store: Store, keep: set[tuple[str, str]]) -> Iterator[Path]:
    """Folders of artifacts that are damaged or not in ``keep``, and left-over temporary files."""
    for stage, key in store.folders():
        folder = store.folder(stage, key)
        if (stage, key) not in keep or store.state(stage, key) is not State.PRESENT:
            yield folder
        else:
            yield from (file for file in folder.glob(f"{TEMPORARY}*") if _stale(file))


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns 0, 3 when ``verify`` finds damage, 2 when there is nothing to work on."""
    options = _parser().parse_args(arguments)
    console = Console(highlight=False, soft_wrap=True)
    store = Store(options.store)
    if not store.root.is_dir():
        console.print(f"{store.root}: there is no store here; give --store DIR")
        return BAD_START
    if options.command == "du":
        _show_usage(usage(store), console)
        return OK
    if options.command == "verify":
        return _verify(store, console)
    return _collect_garbage(store, options.outputs, options.dry_run, console)


def _show_usage(found: Sequence[Usage], console: Console) -> None:
    table = Table()
    table.add_column("stage")
    table.add_column("artifacts", justify="right")
    table.add_column("MB", justify="right")
    for one in found:
        table.add_row(one.stage, f"{one.artifacts:,}", f"{one.size / 1e6:,.1f}")
    table.add_section()
    table.add_row("all", f"{sum(one.artifacts for one in found):,}", f"{sum(one.size for one in found) / 1e6:,.1f}")
    console.print(table)


def _verify(store: Store, console: Console) -> int:
    found = damaged(store)
    for stage, key in found:
        console.print(f"corrupt or not committed: {stage}/{key}")
    total = sum(1 for _ in store.folders())
    console.print(
        f"{several(total, 'artifact')}, {len(found)} damaged" + ("; the next run makes them again" if found else "")
    )
    return DAMAGED if found else OK


def _collect_garbage(store: Store, outputs: Path, dry_run: bool, console: Console) -> int:
    try:
        keep, runs = needed(outputs)
    except StartError as error:
        console.print(str(error), markup=False)
        return BAD_START
    if runs == 0:
        console.print(
            f"{outputs}: no finished run here names what it needs, so that everything would go; "
            f"give --outputs DIR, or delete {store.root} yourself"
        )
        return BAD_START
    count = size = 0
    for path in list(garbage(store, keep)):
        count += 1
        size += sum(file.stat().st_size for file in path.rglob("*")) if path.is_dir() else path.stat().st_size
        if not dry_run and path.is_dir():
            shutil.rmtree(path)
        elif not dry_run:
            path.unlink(missing_ok=True)
    verb = "would be deleted" if dry_run else "deleted"
    what = several(count, "artifact or left-over file", "artifacts or left-over files")
    keeping = several(runs, "run keeps", "runs keep")
    console.print(f"{what}, {size / 1e6:,.1f} MB, {verb}; {keeping} {several(len(keep), 'artifact')}")
    return OK


def _stale(file: Path) -> bool:
    return time.time() - file.stat().st_mtime > STALE_SECONDS


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m pipeline.cache", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    for name, text in (
        ("du", "what each stage takes"),
        ("verify", "check every artifact down to the last byte"),
        ("gc", "delete what no finished run below --outputs needs, and what is damaged"),
    ):
        command = commands.add_parser(name, help=text)
        command.add_argument("--store", type=Path, default=Path("store"), help="the store (default: store)")
        if name == "gc":
            command.add_argument("--outputs", type=Path, default=Path("outputs"), help="runs to keep for")
            command.add_argument("--dry-run", action="store_true", help="say what would go, delete nothing")
    return parser


if __name__ == "__main__":
    sys.exit(main())

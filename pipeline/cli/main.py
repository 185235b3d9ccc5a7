"""The program ``riot``: every command by name. `python -m pipeline.run` and its like are commands of it."""

from __future__ import annotations

import sys
from collections.abc import Sequence

import pipeline.runtime.threads  # noqa: F401  (before anything that loads a numeric library)
import studio  # lazy
from pipeline import cli
from pipeline.exit_codes import BAD_START, CLEAN
from pipeline.study.registry import STUDIES
from riot import cli as library
from riot.cli.command import Command, Group
from riot.cli.main import COMMANDS, SUMMARY
from riot.cli.program import run_program

MODULES = {
    "python -m pipeline.run": "riot mine",
    "python -m pipeline.cache": "riot cache",
    "python -m pipeline.fetch": "riot fetch",
    "python -m pipeline.study": "riot study",
}
"""Commands that are modules as well, by what messages call them."""

RESUMES = "Interrupted. What is done is kept: the same command goes on from here."

STUDY = Group(
    "ask a question of a finished run: a table, figures and a page",
    {
        "list": Command("what studies there are", lambda: cli.study.LIST, "mine"),
        **{
            name: Command(meaning, lambda name=name: cli.study.StudyCommand(name), "mine", RESUMES)  # type: ignore[misc]
            for name, meaning in STUDIES.items()
        },
    },
    "study",
    "studies",
    {CLEAN: "Done.", BAD_START: "It could not be done; the message says why."},
)

CACHE = Group(
    "measure, check and tidy the store, which keeps what runs computed",
    {
        "du": Command("what each stage takes", lambda: cli.cache.DU, "mine"),
        "verify": Command("check every artifact down to the last byte", lambda: cli.cache.VERIFY, "mine"),
        "gc": Command("delete what no finished run needs, and what is damaged", lambda: cli.cache.GC, "mine"),
        "accept": Command(
            "after an edit that changes no result: keep a run's artifacts for the code that is here now",
            lambda: cli.cache.ACCEPT,
            "mine",
        ),
    },
)

FETCH = Group(
    "fetch a public data set, and check every picture of it",
    {
        "mpeg7": Command("1,400 silhouettes, MPEG-7 CE-Shape-1 part B", lambda: cli.fetch.MPEG7, "mine"),
        "manifest": Command(
            "list a folder's pictures with digests of their pixels", lambda: cli.fetch.MANIFEST, "mine"
        ),
    },
)

RIOT: Group = Group(
    SUMMARY,
    {
        "mine": Command(
            "mine a collection for the pairs that do, with tables and a report", lambda: cli.mine, "mine", RESUMES
        ),
        "check": Command(
            "show every outline of a folder on its picture, the doubtful ones first", lambda: cli.check, "mine"
        ),
        "match": Command("find the best partners of a silhouette in a mined collection", lambda: cli.match, "mine"),
        "study": STUDY,
        "cache": CACHE,
        "fetch": FETCH,
        **COMMANDS,
        "studio": Command(
            "work on a transform in the browser", lambda: studio.command, "studio", "Ended; everything is kept."
        ),
        "slices": Command(COMMANDS["slices"].summary, lambda: cli.slices, "mine"),
        "completion": Command(
            "print a script that completes commands in a shell", lambda: library.completion.CompletionCommand(RIOT)
        ),
    },
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; returns its exit code."""
    return run_program("riot", RIOT, arguments, MODULES)


def run_command(name: str, program: str, arguments: Sequence[str] | None = None) -> int:
    """Run the command ``name`` as a program of its own, called ``program`` in messages; returns its exit code."""
    return run_program(program, RIOT.commands[name], arguments, command=name)


if __name__ == "__main__":
    sys.exit(main())

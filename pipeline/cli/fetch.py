"""The commands `riot fetch mpeg7|manifest`: get a public data set, and list the pictures of a folder. Ours."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

from pipeline.datasets.collection import default_root
from pipeline.datasets.fetch import MPEG7_MANIFEST, MPEG7_URLS, fetch, write_manifest
from pipeline.errors import StartError
from pipeline.exit_codes import CLEAN
from riot.cli.output import Output
from riot.cli.parser import Parser


class FetchMpeg7:
    """Fetch MPEG-7."""

    def add_options(self, parser: Parser) -> None:
        """See `riot.cli.command.CommandModule`."""
        parser.add_argument("--to", type=Path, metavar="DIR", help="folder to make (default: the user's cache folder)")
        parser.add_argument(
            "--from", dest="urls", action="append", metavar="URL", help="another address of the archive"
        )

    def run(self, chosen: argparse.Namespace, output: Output) -> int:
        """See `riot.cli.command.CommandModule`."""
        target = chosen.to or default_root("mpeg7")
        new = fetch(target, chosen.urls or MPEG7_URLS)
        argument = "" if chosen.to is None else f" dataset.root={os.fspath(target)}"
        output.facts(
            {"folder": target, "fetched": new},
            f"{target}: {'fetched and checked' if new else 'already there and checked'}",
            f"Now: python -m pipeline.run +dataset=mpeg7{argument}",
        )
        return CLEAN


class ListManifest:
    """List the pictures of a folder with digests of their pixels."""

    def add_options(self, parser: Parser) -> None:
        """See `riot.cli.command.CommandModule`."""
        parser.add_argument("folder", type=Path, metavar="DIR", help="a folder of pictures")
        parser.add_argument("--to", type=Path, metavar="FILE", default=MPEG7_MANIFEST, help="the list to write")

    def run(self, chosen: argparse.Namespace, output: Output) -> int:
        """See `riot.cli.command.CommandModule`."""
        try:
            count = write_manifest(chosen.folder, chosen.to)
        except ValueError as error:  # whatever a decoder finds wrong with a picture
            raise StartError(str(error)) from error
        output.facts({"manifest": chosen.to, "pictures": count}, f"{chosen.to}: {count} pictures")
        return CLEAN


MPEG7, MANIFEST = FetchMpeg7(), ListManifest()

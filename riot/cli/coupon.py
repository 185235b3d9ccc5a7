"""The command `riot coupon -o DIR`: test pieces of a printer and a laser, to measure clearances and the kerf. Ours."""

from __future__ import annotations

import argparse
from pathlib import Path

from riot.cli.common_options import add_force
from riot.cli.output import Output
from riot.cli.parser import Parser
from riot.cli.profiles import own_profiles
from riot.cli.size_options import add_sizes, chosen_sizes
from riot.fabricate.coupon import CLEARANCES_MM, INTERFERENCES_MM, coupon
from riot.fabricate.export.folder import check_folder, new_folder
from riot.fabricate.export.laser_coupon import laser_coupon
from riot.fabricate.export.laser_sheet import laser_sheets, svg_bytes
from riot.fabricate.export.plate_file import plate_bytes
from riot.fabricate.export.stl import stl_bytes
from riot.fabricate.plates import lay_out

_STALE = ("bar.stl", "arm-*.stl", "joint-*.stl", "pin.stl", "cap.stl", "plate-*.3mf", "laser-coupon.svg")


def add_options(parser: Parser) -> None:
    """See `riot.cli.command.CommandModule`."""
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="DIR", help="a folder for the files")
    add_sizes(parser, without=("size_mm", "clearance_mm", "press_mm"))
    add_force(parser)


def run(chosen: argparse.Namespace, output: Output) -> int:
    """See `riot.cli.command.CommandModule`."""
    parameters = chosen_sizes(chosen)
    check_folder(chosen.output, replace_files=chosen.replace_files)
    parts = coupon(parameters)
    plates = lay_out(parts, parameters)
    (sheet,) = laser_sheets(laser_coupon(parameters), parameters)
    data = {f"{part.name}.stl": stl_bytes(part) for part in parts}
    data |= {f"plate-{k + 1}.3mf": plate_bytes(plate, parts, "coupon", {}) for k, plate in enumerate(plates)}
    data["laser-coupon.svg"] = svg_bytes(sheet, "kerf and fit of the pin, a test piece")
    with new_folder(chosen.output, replace_files=chosen.replace_files, stale=_STALE) as temporary:
        for name, content in data.items():
            (temporary / name).write_bytes(content)
    files = [chosen.output / name for name in data]
    in_place = parameters.pivot == "in-place"
    interferences = () if in_place else INTERFERENCES_MM
    arms = "joints: break each free, and turn it; " if in_place else "arms: "
    output.show(f"{arms}clearances of {_listed(CLEARANCES_MM)} mm; the least that turns freely is your clearance_mm")
    if interferences:
        output.show(f"bar: interferences of {_listed(interferences)} mm; the least that holds the pin is your press_mm")
    output.show(f"write what you find into {own_profiles()}, and use it with profile")
    output.facts({"clearances_mm": CLEARANCES_MM, "interferences_mm": interferences, "files": files}, *map(str, files))
    return 0


def _listed(lengths: tuple[float, ...]) -> str:
    return ", ".join(f"{length:.2f}" for length in lengths)

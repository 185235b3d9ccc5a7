"""Profiles of makers' machines: parameters of fabrication by name, shipped ones and the user's own (TOML). Ours."""

from __future__ import annotations

import importlib
import tomllib
from collections.abc import Mapping
from dataclasses import fields
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

from riot.errors import FormatError, ParameterError, needs_extra
from riot.parameters import FabricationParameters
from riot.parameters.fabrication import PIVOTS

FILE = "makers.toml"
KIND, KINDS = "kind", ("printer", "laser", "material")
"""What a profile is of, which the help lists them by; one of your own need not tell."""


def own_profiles() -> Path:
    """The file of the user's own profiles, which need not be there.

    Raises `riot.errors.MissingExtraError` without the package that knows where it is.
    """
    with needs_extra("print"):  # here, since the help of commands does without
        platformdirs = importlib.import_module("platformdirs")
    return Path(platformdirs.user_config_dir("riot", appauthor=False)) / FILE


@cache
def shipped_profiles() -> Mapping[str, Mapping[str, Any]]:
    """The profiles that come with the program, by name."""
    return tomllib.loads((resources.files("riot.cli") / FILE).read_text(encoding="utf-8"))


def shipped_in_words() -> str:
    """The names of the shipped profiles by their kinds.

    >>> shipped_in_words().startswith("printers prusa-mini, ")
    True
    """
    named = {kind: [name for name, entry in shipped_profiles().items() if entry[KIND] == kind] for kind in KINDS}
    return "; ".join(f"{kind}s {', '.join(names)}" for kind, names in named.items())


def profile(names: str, own: Path | None = None) -> Mapping[str, Any]:
    """Parameters of fabrication of a profile, or of several with commas between, the later ones before the earlier.

    One of the user's own goes before a shipped one. Raises `riot.errors.ParameterError` for a name that there is none
    of, `riot.errors.FormatError` for a file that is not TOML or sets what is no parameter.

    >>> profile("k40,plywood-3mm", Path("nowhere.toml")) == {
    ...     "bed_width_mm": 310, "bed_depth_mm": 210, "sheet_mm": 3.0, "kerf_mm": 0.2}
    True
    """
    own = own_profiles() if own is None else own
    known = {**shipped_profiles(), **(_read(own) if own.exists() else {})}
    chosen: dict[str, Any] = {}
    for name in names.split(","):
        if name not in known:
            raise ParameterError("profile", f"there is no {name!r}; choose of {', '.join(known)}, or add it to {own}")
        chosen |= _checked(name, known[name], own)
    return chosen


def _checked(name: str, values: Any, own: Path) -> dict[str, Any]:
    allowed = {field.name for field in fields(FabricationParameters)}
    strange = sorted(set(values) - allowed - {KIND}) if isinstance(values, dict) else [name]
    if strange:
        raise FormatError(f"{own}: [{name}] sets {', '.join(strange)}; parameters are {', '.join(sorted(allowed))}")
    if values.get("pivot", "printed") not in PIVOTS:
        raise FormatError(f"{own}: [{name}] pivot: choose one of {', '.join(PIVOTS)}")
    return {key: value for key, value in values.items() if key != KIND}


def _read(path: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise FormatError(f"{path}: is no TOML: {error}") from error

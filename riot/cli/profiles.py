"""Profiles of makers' machines: parameters of fabrication by name, shipped ones and the user's own (TOML). Ours."""

from __future__ import annotations

import importlib
import tomllib
from collections.abc import Mapping
from dataclasses import fields
from importlib import resources
from pathlib import Path
from typing import Any

from riot.errors import FormatError, ParameterError, needs_extra
from riot.parameters import FabricationParameters
from riot.parameters.fabrication import PIVOTS

FILE = "makers.toml"


def own_profiles() -> Path:
    """The file of the user's own profiles, which need not be there.

    Raises `riot.errors.MissingExtraError` without the package that knows where it is.
    """
    with needs_extra("print"):  # here, since the help of commands does without
        platformdirs = importlib.import_module("platformdirs")
    return Path(platformdirs.user_config_dir("riot", appauthor=False)) / FILE


def profile(name: str, own: Path | None = None) -> Mapping[str, Any]:
    """Parameters of fabrication of a profile; one of the user's own goes before a shipped one.

    Raises `riot.errors.ParameterError` for a name that there is none of, `riot.errors.FormatError` for a file that is
    not TOML or sets what is no parameter.

    >>> profile("prusa-mini", Path("nowhere.toml"))["bed_width_mm"]
    180
    """
    own = own_profiles() if own is None else own
    shipped = tomllib.loads((resources.files("riot.cli") / FILE).read_text(encoding="utf-8"))
    known = {**shipped, **(_read(own) if own.exists() else {})}
    if name not in known:
        raise ParameterError("profile", f"there is no {name!r}; choose one of {', '.join(known)}, or add it to {own}")
    values = known[name]
    allowed = {field.name for field in fields(FabricationParameters)}
    strange = sorted(set(values) - allowed) if isinstance(values, dict) else [name]
    if strange:
        raise FormatError(f"{own}: [{name}] sets {', '.join(strange)}; parameters are {', '.join(sorted(allowed))}")
    if values.get("pivot", "printed") not in PIVOTS:
        raise FormatError(f"{own}: [{name}] pivot: choose one of {', '.join(PIVOTS)}")
    return dict(values)


def _read(path: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise FormatError(f"{path}: is no TOML: {error}") from error

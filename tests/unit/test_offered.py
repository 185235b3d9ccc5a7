"""What ``import riot`` offers: the same objects whatever was imported before, and nothing loaded before it is used."""

from __future__ import annotations

import subprocess
import sys
from types import ModuleType

import pytest

import riot
import riot.fabricate.offered
import riot.motion.offered
import riot.offered

PACKAGES = [(riot, riot.offered), (riot.motion, riot.motion.offered), (riot.fabricate, riot.fabricate.offered)]


def says(code: str) -> str:
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=120).stdout


@pytest.mark.parametrize(("package", "offered"), PACKAGES, ids=lambda module: module.__name__)
def test_every_name_is_what_its_module_has(package: ModuleType, offered: ModuleType) -> None:
    for name in offered.__all__:
        assert getattr(package, name) is vars(offered)[name] and name in dir(package)
        assert not isinstance(vars(offered)[name], ModuleType)
    with pytest.raises(AttributeError, match="nothing_of_this_name"):
        package.nothing_of_this_name  # noqa: B018


def test_names_shared_with_modules_are_the_functions_in_any_order() -> None:
    imported = "import riot.scores.trunks, riot.construction, riot.scores.reversibility, riot.fabricate.design"
    named = "from riot import trunks, construct, reversibility\nfrom riot.fabricate import design"
    for first, then in ((imported, named), (named, imported)):
        assert says(f"{first}\n{then}\nprint(*map(callable, (trunks, construct, reversibility, design)))") == (
            "True True True True\n"
        )
    assert says("from riot import *\nprint(callable(trunks), Shape.__name__)") == "True Shape\n"


def test_errors_and_parameters_load_no_numeric_library() -> None:
    imported = (
        "import sys, riot.errors, riot.parameters.motion, riot.parameters.fabrication\nfrom riot import parameters"
    )
    listed = "print([name for name in ('numba', 'scipy', 'shapely') if name in sys.modules])"
    assert says(f"{imported}\n{listed}") == "[]\n"

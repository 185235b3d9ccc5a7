"""What ``import riot`` offers: the same objects whatever was imported before, and nothing loaded before it is used."""

from __future__ import annotations

import subprocess
import sys

import pytest

import riot
from riot import offered

NAMESAKES = [name for name in offered.__all__ if f"riot.{name}" in sys.modules]


def says(code: str) -> str:
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=120).stdout


def test_every_name_is_what_its_module_has() -> None:
    assert {"construct", "reversibility", "trunks"} == set(NAMESAKES)
    for name in offered.__all__:
        assert getattr(riot, name) is getattr(offered, name) and name in dir(riot)
    with pytest.raises(AttributeError, match="nothing_of_this_name"):
        riot.nothing_of_this_name  # noqa: B018


def test_names_shared_with_modules_are_the_functions_in_any_order() -> None:
    late = "import riot.trunks, riot.construct, riot.reversibility\nfrom riot import trunks, construct, reversibility\n"
    early = (
        "from riot import trunks, construct, reversibility\nimport riot.trunks, riot.construct, riot.reversibility\n"
    )
    for first in (late, early):
        assert (
            says(first + "print(callable(trunks), callable(construct), callable(reversibility))") == "True True True\n"
        )
    assert says("from riot import *\nprint(callable(trunks), Shape.__name__)") == "True Shape\n"


def test_errors_and_parameters_load_no_numeric_library() -> None:
    code = "import sys, riot.errors\nfrom riot import parameters\nprint([name for name in ('numba', 'scipy') if name in sys.modules])"
    assert says(code) == "[]\n"

"""What the packages of ``riot`` offer: the same objects whatever was imported before, and nothing loaded before use."""

from __future__ import annotations

import importlib
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest

import riot

ROOT = Path(riot.__file__).parents[1]
FACES = sorted(".".join(stub.parent.relative_to(ROOT).parts) for stub in (ROOT / "riot").rglob("__init__.pyi"))
NUMERIC = ("numpy", "numba", "scipy", "shapely", "skimage", "matplotlib")


def output(code: str) -> str:
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=120).stdout


@pytest.mark.parametrize("name", FACES)
def test_a_face_offers_every_name_of_its_stub(name: str) -> None:
    face = importlib.import_module(name)
    assert face.__doc__ and face.__all__ == dir(face)
    for offered in face.__all__:
        value = getattr(face, offered)
        assert not isinstance(value, ModuleType) or value.__name__ == f"{name}.{offered}"
    with pytest.raises(AttributeError, match="nothing_of_this_name"):
        face.nothing_of_this_name  # noqa: B018


def test_names_shared_with_modules_are_the_functions_in_any_order() -> None:
    modules = "import riot.scores.trunks, riot.construction, riot.scores.reversibility, riot.fabricate.design"
    functions = "from riot import trunks, construct, reversibility\nfrom riot.fabricate import design"
    for first, then in ((modules, functions), (functions, modules)):
        assert output(f"{first}\n{then}\nprint(*map(callable, (trunks, construct, reversibility, design)))") == (
            "True True True True\n"
        )
    assert output("from riot import *\nprint(callable(trunks), Shape.__name__)") == "True Shape\n"


def test_faces_errors_and_parameters_load_no_numeric_library() -> None:
    imports = "\n".join(f"import {name}" for name in FACES)
    parameters = "import riot.errors, riot.parameters.motion, riot.parameters.fabrication, riot.draw.texture.names"
    loaded = f"import sys\nprint([name for name in {NUMERIC} if name in sys.modules])"
    assert output(f"{imports}\n{parameters}\n{loaded}") == "[]\n"

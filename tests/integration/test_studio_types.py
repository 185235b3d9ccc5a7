"""The studio's modules keep the types that their comments declare, as TypeScript checks them."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from pipeline.plan.sources import ROOT

PROJECT = ROOT / "studio" / "jsconfig.json"
TSC = shutil.which("tsc")

pytestmark = [
    pytest.mark.system,
    pytest.mark.skipif(TSC is None, reason="TypeScript is not installed: npm install --global typescript"),
]


def checked(project: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run([str(TSC), "--project", str(project)], capture_output=True, text=True, timeout=240)


def test_modules_are_of_their_types() -> None:
    ended = checked(PROJECT)
    assert ended.returncode == 0, ended.stdout


def test_a_wrong_type_is_found(tmp_path: Path) -> None:
    shutil.copytree(PROJECT.parent / "static" / "js", tmp_path / "static" / "js")
    shutil.copy(PROJECT, tmp_path)
    with (tmp_path / "static" / "js" / "geometry.js").open("a", encoding="utf-8") as file:
        file.write("\n/** @type {number} */\nexport const wrong = 'text';\n")
    ended = checked(tmp_path / PROJECT.name)
    assert ended.returncode != 0 and "geometry.js" in ended.stdout and ended.stdout.count("error") == 1

"""No file that is read can run code: nothing in the project unpickles, evaluates or executes what it reads."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SOURCES = sorted(path for package in ("riot", "pipeline", "benchmarks") for path in (ROOT / package).rglob("*.py"))

MODULES = {"pickle", "cPickle", "_pickle", "dill", "cloudpickle", "joblib", "shelve", "marshal", "dbm", "code", "runpy"}
"""None of these is imported."""

BUILTINS = {"eval", "exec", "compile", "__import__", "breakpoint"}
"""None of these is called."""

METHODS = {"read_pickle", "to_pickle", "literal_eval", "unsafe_load", "full_load", "system", "popen"}
"""No method or function of a module with such a name is called."""

CONNECTION = "multiprocessing.connection"
"""It pickles: only between a process and the one that it starts, never what a file holds."""


def found(tree: ast.AST) -> set[str]:
    """What a module uses of all that could run what it reads."""
    names: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names |= {name for name in (alias.name for alias in node.names) if _suspect(name)}
        elif isinstance(node, ast.ImportFrom) and _suspect(node.module or ""):
            names.add(str(node.module))
        elif isinstance(node, ast.Call):
            if isinstance(node.func, ast.Name) and node.func.id in BUILTINS:
                names.add(node.func.id)
            if isinstance(node.func, ast.Attribute) and node.func.attr in METHODS:
                names.add(node.func.attr)
            for keyword in node.keywords:
                if keyword.arg in ("allow_pickle", "shell"):
                    constant = isinstance(keyword.value, ast.Constant) and keyword.value.value is False
                    names |= set() if constant else {keyword.arg}
    return names


def _suspect(module: str) -> bool:
    return module.split(".")[0] in MODULES or module == CONNECTION


def test_no_module_runs_what_it_reads() -> None:
    used = {path.relative_to(ROOT).as_posix(): found(ast.parse(path.read_bytes())) for path in SOURCES}
    assert {path: names for path, names in used.items() if names} == {
        "pipeline/runtime/isolated_process.py": {CONNECTION},
        "pipeline/runtime/isolation.py": {CONNECTION},
    }


@pytest.mark.parametrize(
    "code",
    [
        "import pickle",
        "from joblib import load",
        "import numpy as np\nnp.load(path, allow_pickle=True)",
        "np.load(path, allow_pickle=wished)",
        "eval(text)",
        "pandas.read_pickle(path)",
        "subprocess.run(text, shell=True)",
        "from multiprocessing.connection import Connection",
    ],
)
def test_what_is_looked_for_is_found(code: str) -> None:
    assert found(ast.parse(code))
    assert not found(ast.parse("np.load(path, allow_pickle=False)\njson.loads(text)\nsubprocess.run([text])"))

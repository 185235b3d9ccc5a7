"""Where Numba keeps compiled kernels, and which modules are there in full.

Numba keeps a kernel in the first of three folders that can be written: ``NUMBA_CACHE_DIR``, ``__pycache__`` beside the
module, and the user's cache folder (`numba.core.caching`). `cache_folder` chooses as Numba does without loading it. A
record beside the kernels of a module tells what they were compiled from, for whoever only asks whether they are there;
Numba has stamps of its own, so a wrong record costs time and never a result. Ours.
"""

from __future__ import annotations

import contextlib
import hashlib
import importlib
import json
import os
import platform
import sys
import tempfile
from collections.abc import Iterator, Sequence
from functools import cache
from importlib import metadata
from itertools import takewhile
from pathlib import Path

from riot.kernels.compiling.uses import kernel_modules

FOLDER = Path(os.path.abspath(__file__)).parents[1]  # noqa: PTH100  (links stay: Numba hashes the name that it sees)
SHARED = ("options.py", "forest.py", "bounds.py")
"""Files that all modules of kernels stand on: when one changes, every kernel is compiled again."""

COMPILER = ("numba", "llvmlite", "numpy")
CPU_SETTINGS = ("NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES")
CPU_FACTS = ("vendor_id", "model name", "flags", "CPU implementer", "CPU part", "Features")
"""Lines of ``/proc/cpuinfo`` on which machine code depends."""

NO_FOLDER = "no folder for them can be written; NUMBA_CACHE_DIR=DIR names another"


def uncompiled(names: Sequence[str] | None = None) -> list[str]:
    """Names of the modules, by default all, whose kernels are not in the cache as the sources are now."""
    names = kernel_modules() if names is None else names
    if os.environ.get("NUMBA_DISABLE_JIT", "0") != "0":
        return []
    folder = cache_folder()
    if folder is None:
        return list(names)
    files = {entry.name for entry in os.scandir(folder)}
    return [name for name in names if not _is_whole(folder, name, files)]


def compile_module(name: str) -> None:
    """Compile the kernels of a module into the cache, with all that it takes from there if it is in it.

    Raises OSError if the cache takes no more.
    """
    folder = cache_folder()
    if folder is None:
        raise OSError(NO_FOLDER)
    importlib.import_module(f"riot.kernels.{name}").warm()
    if unkept := importlib.import_module("riot.kernels.options").unkept:
        raise OSError(f"{folder}: {unkept[0]}")
    files = [path.name for path in _indexes(folder, name)]
    _replace(folder / _record(name), json.dumps({"code": _code(name), "files": files}))


def cache_folder() -> Path | None:
    """The folder in which Numba keeps compiled kernels; None if none can be written."""
    return next((folder for folder in _folders() if _is_writable(folder)), None)


def _folders() -> Iterator[Path]:
    apart = f"{FOLDER.name}_{hashlib.sha1(str(FOLDER).encode()).hexdigest()}"
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    if chosen:
        yield Path(chosen, apart)
    yield FOLDER / "__pycache__"
    yield _user_cache() / apart


def _user_cache() -> Path:
    """The folder that Numba has in the user's cache."""
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local", "numba", "Cache")
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "numba"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache", "numba")


def _is_writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()  # permissions do not tell: of root, or of a read-only disk
    except OSError:
        return False
    return True


def _is_whole(folder: Path, name: str, files: set[str]) -> bool:
    """Whether the record of a module is of the code as it is now, and its files are still among ``files``."""
    try:
        record = json.loads((folder / _record(name)).read_bytes())
        return record["code"] == _code(name) and files.issuperset(record["files"])
    except (OSError, ValueError, KeyError, TypeError):
        return False


def _record(name: str) -> str:
    return f"{name}.{_machine()}.json"


def _indexes(folder: Path, name: str) -> list[Path]:
    tag = f"py{sys.version_info[0]}{sys.version_info[1]}{getattr(sys, 'abiflags', '')}"
    return sorted(folder.glob(f"{name}.*.{tag}.nbi"))


@cache
def _code(name: str) -> str:
    """The digest of the code of a module's kernels."""
    return hashlib.sha256((FOLDER / f"{name}.py").read_bytes() + shared_code().encode()).hexdigest()


@cache
def shared_code() -> str:
    """The digest of the files that all modules of kernels stand on."""
    return hashlib.sha256(b"\0".join((FOLDER / file).read_bytes() for file in SHARED)).hexdigest()


@cache
def _machine() -> str:
    """A digest of what compiles and of the CPU: a folder may serve several machines."""
    compilers = [f"{name} {metadata.version(name)}" for name in COMPILER]
    settings = [os.environ.get(name, "") for name in CPU_SETTINGS]
    facts = [sys.version, platform.platform(), *compilers, *settings, *_cpu()]
    return hashlib.sha256("\0".join(facts).encode()).hexdigest()[:16]


def _cpu() -> list[str]:
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as file:  # noqa: PTH123  (only its beginning, the first CPU)
            return [line for line in takewhile(str.strip, file) if line.startswith(CPU_FACTS)]
    except OSError:
        return [platform.processor()]


def _replace(path: Path, text: str) -> None:
    """Write a file in whole, or not at all."""
    partial = path.with_name(f"{path.name}.{os.getpid()}")
    try:
        partial.write_text(text, encoding="utf-8")
        partial.replace(path)
    except OSError:
        with contextlib.suppress(OSError):
            partial.unlink()
        raise

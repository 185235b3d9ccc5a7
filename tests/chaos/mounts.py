"""Small disks of a victim's own, which it fills, locks and grows: nobody else sees them, and they end with it."""

from __future__ import annotations

import ctypes
import os
import subprocess
from pathlib import Path

NEW_MOUNTS, NEW_USER = 0x00020000, 0x10000000
"""``CLONE_NEWNS`` and ``CLONE_NEWUSER`` of Linux."""


def leave() -> None:
    """Leave the file systems that others see, as ``unshare -Urm`` does; OSError where that is not permitted."""
    user, group = os.geteuid(), os.getegid()
    system = ctypes.CDLL(None, use_errno=True)
    if not hasattr(system, "unshare"):
        raise OSError("no Linux")
    if system.unshare(NEW_MOUNTS | NEW_USER):
        number = ctypes.get_errno()
        raise OSError(number, os.strerror(number))
    Path("/proc/self/setgroups").write_text("deny")
    Path("/proc/self/uid_map").write_text(f"0 {user} 1")
    Path("/proc/self/gid_map").write_text(f"0 {group} 1")


def try_to_leave(folder: Path, why: Path) -> None:
    """Write into ``why`` what keeps a victim here from having disks of its own; nothing if it can."""
    try:
        leave()
        disk(folder, 64)
        change(folder, "ro")
    except (OSError, subprocess.CalledProcessError) as error:
        why.write_text(str(error))


def disk(folder: Path, kilobytes: int) -> None:
    """Mount an empty disk of so many kilobytes."""
    folder.mkdir(parents=True, exist_ok=True)
    _mount("-t", "tmpfs", "-o", f"size={kilobytes}k", "tmpfs", str(folder))


def change(folder: Path, *options: str) -> None:
    """Change a disk: ``size=…k``, ``ro``, ``rw``."""
    _mount("-o", ",".join(("remount", *options)), str(folder))


def _mount(*arguments: str) -> None:
    subprocess.run(["mount", *arguments], check=True, capture_output=True)

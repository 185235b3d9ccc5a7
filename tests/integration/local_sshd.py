"""An SSH server of this machine for one test, and the home folder of a user who may log in there."""

from __future__ import annotations

import getpass
import shutil
import socket
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

SSHD = shutil.which("sshd") or shutil.which("sshd", path="/usr/sbin:/usr/local/sbin")
HOSTS = ("node-a", "node-b")


def make_key(path: Path) -> str:
    subprocess.run(["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", str(path)], check=True)
    return path.with_suffix(".pub").read_text(encoding="ascii")


@contextmanager
def ssh_home(folder: Path) -> Iterator[Path]:
    """A home whose ``.ssh/config`` leads `HOSTS` to a server that runs meanwhile."""
    assert SSHD is not None
    settings = folder / "home" / ".ssh"
    settings.mkdir(parents=True, mode=0o700)
    host_key, _ = make_key(folder / "host"), make_key(settings / "id_ed25519")
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        port = found.getsockname()[1]
    (folder / "sshd_config").write_text(
        f"Port {port}\nListenAddress 127.0.0.1\nHostKey {folder / 'host'}\nPidFile none\nUsePAM no\nStrictModes no\n"
        f"AuthorizedKeysFile {settings / 'id_ed25519.pub'}\nPasswordAuthentication no\nPermitRootLogin yes\n",
        encoding="ascii",
    )
    names = ",".join(name for host in (*HOSTS, "127.0.0.1") for name in (host, f"[{host}]:{port}"))
    (settings / "known_hosts").write_text(f"{names} {host_key}", encoding="ascii")
    (settings / "config").write_text(
        f"Host {' '.join(HOSTS)}\n  HostName 127.0.0.1\n  Port {port}\n  User {getpass.getuser()}\n"
        f"  IdentityFile {settings / 'id_ed25519'}\n",
        encoding="ascii",
    )
    Path("/run/sshd").mkdir(exist_ok=True)
    server = subprocess.Popen([SSHD, "-D", "-f", str(folder / "sshd_config")], stderr=subprocess.DEVNULL)
    try:
        yield folder / "home"
    finally:
        server.terminate()
        server.wait()

"""Signed artifacts: a reader with the key takes what was written with it, and no other; the key stays in its file."""

from __future__ import annotations

import json
import pickle
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.cli.main import main
from pipeline.config.command_line import check_command, complete
from pipeline.errors import SignatureError, StartError
from pipeline.store.artifact import Artifact
from pipeline.store.keys import KeyParts
from pipeline.store.signing import FILE, Signing
from pipeline.store.store import MANIFEST, PAYLOAD, State, Store

SECRET = "5f" * 32
PARTS = KeyParts("ingest", {"spacing": 1.0}, ("ab",), {"code": "1"}, {"numpy": "2"})
ARTIFACT = Artifact({"values": np.arange(5.0)}, {"name": "x"})
COST = {"seconds": 0.25}


def key_file(folder: Path, text: str = SECRET, mode: int = 0o600) -> Signing:
    folder.mkdir(exist_ok=True)
    path = folder / FILE
    path.write_text(f"{text}\n", encoding="ascii")
    path.chmod(mode)
    return Signing(str(path))


@pytest.fixture
def signing(tmp_path: Path) -> Signing:
    return key_file(tmp_path / "keys")


@pytest.fixture
def store(tmp_path: Path, signing: Signing) -> Store:
    return Store(tmp_path / "store", signing)


def test_what_is_signed_is_read_and_has_the_same_payload(store: Store, tmp_path: Path) -> None:
    key = store.put(PARTS, ARTIFACT, COST)
    assert store.state("ingest", key) is State.PRESENT and store.glance("ingest", key)[0] is State.PRESENT
    assert store.read("ingest", key).document == ARTIFACT.document
    plain = Store(tmp_path / "plain")
    assert plain.put(PARTS, ARTIFACT, COST) == key  # a signature enters no key
    payloads = [(one.root / "ingest" / key[:2] / key / PAYLOAD) for one in (store, plain)]  # type: ignore[operator]
    assert payloads[0].read_bytes() == payloads[1].read_bytes()
    assert Store(store.root).read("ingest", key).document == ARTIFACT.document  # who does not ask reads it, too


def test_what_is_not_signed_is_refused_and_kept(store: Store, tmp_path: Path) -> None:
    key = Store(store.root).put(PARTS, ARTIFACT, COST)
    other = Store(store.root, key_file(tmp_path / "others", "0a" * 32))
    for reader in (store, other):
        assert reader.state("ingest", key) is State.UNSIGNED
        for read in (reader.get, reader.read, reader.entry):
            with pytest.raises(SignatureError, match=f"not signed with the key in .*{FILE}: ingest/{key[:12]}"):
                read("ingest", key)
        with pytest.raises(SignatureError, match="choose another store"):
            reader.check_all([("ingest", key)])
        assert list(reader.entries()) == []
        Store(store.root, store.signing).put(PARTS, ARTIFACT, COST)  # for the other: signed by somebody else
    assert Store(store.root).state("ingest", key) is State.PRESENT


@given(st.sampled_from(["digest", "bytes", "cost", "parts", "signature", "accepted"]), st.sampled_from([None, "x", 7]))
def test_any_change_of_a_manifest_is_seen(tmp_path_factory: pytest.TempPathFactory, name: str, value: object) -> None:
    folder = tmp_path_factory.mktemp("signed")
    store = Store(folder / "store", key_file(folder / "keys"))
    key = store.put(PARTS, ARTIFACT, COST)
    file = folder / "store" / "ingest" / key[:2] / key / MANIFEST
    manifest = json.loads(file.read_bytes())
    file.write_text(json.dumps({**manifest, name: value}), encoding="utf-8")
    assert store.state("ingest", key) is not State.PRESENT


def test_the_key_stays_in_its_file(store: Store) -> None:
    store.put(PARTS, ARTIFACT, COST)
    sent = pickle.dumps((store, store.signing))
    assert SECRET.encode() not in sent and SECRET not in repr((store, vars(store).get("files"), store.signing))
    again, _ = pickle.loads(sent)
    assert again.state("ingest", PARTS.key()) is State.PRESENT
    for file in store.root.rglob("*"):  # type: ignore[union-attr]
        assert file.is_dir() or SECRET.encode() not in file.read_bytes()


@pytest.mark.parametrize(
    ("text", "mode", "what"),
    [("short", 0o600, "less than 32 bytes"), (SECRET, 0o604, "everybody can read"), ("", 0, "")],
)
def test_a_bad_key_is_told_with_the_way_to_make_one(tmp_path: Path, text: str, mode: int, what: str) -> None:
    signing = key_file(tmp_path, text, mode) if text else Signing(str(tmp_path / "none" / FILE))
    with pytest.raises(StartError, match=f"{what or 'no key in'}.*openssl rand -hex 32"):
        signing.sign("")


def test_the_users_own_key_is_where_the_configuration_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    here = key_file(tmp_path / "riot")
    assert Signing("user").path == here.path and Signing("user").sign("a") == here.sign("a")
    assert check_command(complete(["sign=user"])).signing == Signing("user")
    assert check_command(complete([])).signing is None


def test_verify_lists_what_is_not_signed(
    store: Store, signing: Signing, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Store(store.root).put(PARTS, ARTIFACT, COST)
    assert main(["cache", "verify", "--store", str(store.root)]) == 0
    assert main(["cache", "verify", "--store", str(store.root), "--sign", signing.name]) == 3
    assert f"not signed: ingest/{PARTS.key()}" in capsys.readouterr().out

"""Folders and object stores pass the same tests; a run on an object store writes the same tables."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from integration.small_runs import digests, pictures
from stores.kit import FilesKit, made, parts

from pipeline.cache import main
from pipeline.config.cluster import ClusterConfig
from pipeline.config.schema import Config
from pipeline.config.selection import SelectConfig
from pipeline.datasets.collection import DatasetConfig
from pipeline.errors import StartError
from pipeline.exit_codes import BAD_START, CLEAN
from pipeline.flow import run_pipeline
from pipeline.store.filesystem.base import Files
from pipeline.store.filesystem.choose import open_files
from pipeline.store.filesystem.local import LocalFiles
from pipeline.store.location import Url, parse_location
from pipeline.store.store import State, Store


class TestFolder(FilesKit):
    examples = 15

    @pytest.fixture
    def files(self, tmp_path: Path) -> Files:
        return LocalFiles(tmp_path / "store")


class TestMemory(FilesKit):
    """fsspec's own file system in memory: the seam without a network."""

    @pytest.fixture
    def files(self, tmp_path: Path) -> Files:
        return open_files(Url(f"memory://{tmp_path.name}"))


@pytest.fixture(scope="module")
def bucket(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Url]:
    """A bucket on a server that speaks S3, and the configuration that a user would have for it."""
    boto3 = pytest.importorskip("boto3", reason="the extra s3")
    server = pytest.importorskip("moto.server", reason="the extra s3-test").ThreadedMotoServer(
        ip_address="127.0.0.1", port=0, verbose=False
    )
    server.start()
    host, port = server.get_host_and_port()
    address = f"http://{host}:{port}"
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("AWS_ENDPOINT_URL", address)
        patch.setenv("AWS_ACCESS_KEY_ID", "nobody")
        patch.setenv("AWS_SECRET_ACCESS_KEY", "nothing")
        patch.setenv("AWS_DEFAULT_REGION", "us-east-1")
        boto3.client("s3").create_bucket(Bucket="shapes")
        yield Url("s3://shapes")
    server.stop()


class TestS3(FilesKit):
    examples = 2

    @pytest.fixture
    def files(self, bucket: Url, tmp_path: Path) -> Files:
        return open_files(bucket.joinpath(tmp_path.name))

    @pytest.mark.chaos
    def test_more_objects_than_a_page_holds(self, files: Files) -> None:
        """A page of a listing holds 1,000."""
        files.write("many", {f"{number:04}": b"" for number in range(1005)})
        assert list(files.names("many")) == [f"{number:04}" for number in range(1005)]


def settings(where: Path, store: Path | Url) -> Config:
    where.mkdir(exist_ok=True)
    dataset = DatasetConfig("folder", "folder", str(pictures(where / "pictures", range(5))))
    select = SelectConfig("global", top=1, breadth=1, per_shape=2)
    return Config(
        dataset, outputs=where / "outputs", store=store, batch=3, select=select, cluster=ClusterConfig("sync")
    )


def test_a_run_on_an_object_store_writes_the_same_tables(
    bucket: Url, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    there = settings(tmp_path / "there", bucket.joinpath("runs", "store"))
    here = settings(tmp_path / "here", tmp_path / "here" / "store")
    far, near = (run_pipeline(config, lambda event: None) for config in (there, here))
    assert far.code == near.code == 0
    assert digests(tmp_path / "there") == digests(tmp_path / "here")
    again = run_pipeline(there, lambda event: None)
    assert all(stage.computed == 0 for stage in again.results.stages) and not again.written
    assert list(Store(there.store).folders()) == list(Store(here.store).folders())
    # The keeper works there, too.
    at = ["--store", str(there.store)]
    assert main(["du", *at]) == CLEAN and main(["verify", *at]) == CLEAN
    store = Store(there.store)
    store.put(parts(1), made(1))
    gc = ["gc", *at, "--outputs", str(there.outputs)]
    assert main(gc) == BAD_START and "--alone" in capsys.readouterr().err
    assert main([*gc, "--alone"]) == CLEAN
    assert store.state("stage", parts(1).key()) is State.ABSENT
    assert list(store.folders()) == list(Store(here.store).folders())


def test_a_bucket_that_is_not_there_is_said_before_anything_is_done(bucket: Url, tmp_path: Path) -> None:
    with pytest.raises(StartError, match="s3://nowhere/store"):
        run_pipeline(settings(tmp_path / "x", Url("s3://nowhere/store")), lambda event: None)


def test_a_protocol_that_nobody_knows_is_said(tmp_path: Path) -> None:
    with pytest.raises(StartError, match="nosuch"):
        open_files(Url("nosuch://bucket/store"))
    config = settings(tmp_path / "x", tmp_path)
    with pytest.raises(StartError, match="nosuch"):
        run_pipeline(replace(config, store=Url("nosuch://bucket")), lambda event: None)


@pytest.mark.parametrize(
    ("text", "location"), [("s3://b/p/", Url("s3://b/p")), ("store", Path("store")), ("/a/b", Path("/a/b"))]
)
def test_a_location_is_parsed_from_its_text(text: str, location: Path | Url) -> None:
    assert parse_location(text) == location and type(parse_location(text)) is type(location)
    assert parse_location(str(location)) == location


@pytest.mark.parametrize("text", ["s3://", "://b", "bucket", "s3:/b", ""])
def test_what_is_no_url_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="no URL"):
        Url(text)

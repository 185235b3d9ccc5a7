"""Solids read from files: the same solid from every format; what is none is refused with a reason."""

from __future__ import annotations

import importlib
import zipfile
from pathlib import Path

import manifold3d
import numpy as np
import pytest
import trimesh

from riot.errors import MissingExtraError
from riot.slices import ModelError, model, read_model

Mesh = tuple[np.ndarray, np.ndarray]


@pytest.fixture(scope="module")
def cup() -> Mesh:
    """A block with a hole through it, a blind one, and a hollow inside: (v, 3) points in mm, (f, 3) triangles."""
    solid = manifold3d.Manifold.cube((40.0, 30.0, 50.0))
    solid -= manifold3d.Manifold.cylinder(60.0, 5.0, 5.0, 24).translate((10.0, 10.0, -5.0))
    solid -= manifold3d.Manifold.cylinder(60.0, 4.0, 4.0, 24).translate((30.0, 20.0, 25.0))
    solid -= manifold3d.Manifold.sphere(4.0, 16).translate((30.0, 10.0, 10.0))
    mesh = solid.to_mesh64()
    return np.array(mesh.vert_properties[:, :3]), np.array(mesh.tri_verts).astype(np.int64)


def saved(mesh: Mesh, path: Path, units: str | None = None) -> Path:
    mesh_file = trimesh.Trimesh(*mesh, process=False)
    mesh_file.units = units
    mesh_file.export(path)
    return path


def volume(mesh: Mesh) -> float:
    return float(trimesh.Trimesh(*mesh, process=False).volume)


@pytest.mark.parametrize("suffix", [".stl", ".3mf", ".obj", ".STL"])
def test_every_format_reads_back_as_the_same_solid(cup: Mesh, suffix: str, tmp_path: Path) -> None:
    model_read = read_model(saved(cup, tmp_path / f"cup{suffix}"))
    assert model_read.name == "cup"
    assert model_read.size == pytest.approx((40.0, 30.0, 50.0), abs=1e-5)
    assert model_read.solid.volume() == pytest.approx(volume(cup), rel=1e-6)


def test_what_is_inside_out_is_turned(cup: Mesh, tmp_path: Path) -> None:
    model_read = read_model(saved((cup[0], cup[1][:, ::-1]), tmp_path / "cup.stl"))
    assert model_read.solid.volume() == pytest.approx(volume(cup), rel=1e-6)


def test_an_inch_is_an_inch(cup: Mesh, tmp_path: Path) -> None:
    path = saved(cup, tmp_path / "cup.3mf")
    with zipfile.ZipFile(path) as archive:
        held = {name: archive.read(name) for name in archive.namelist()}
    with zipfile.ZipFile(path, "w") as archive:
        for name, data in held.items():
            archive.writestr(name, data.replace(b'unit="millimeter"', b'unit="inch"'))
    assert read_model(path).size == pytest.approx((40.0 * 25.4, 30.0 * 25.4, 50.0 * 25.4), rel=1e-6)


def test_closed_parts_are_one_solid(cup: Mesh, tmp_path: Path) -> None:
    both = trimesh.util.concatenate(
        [trimesh.Trimesh(*cup, process=False), trimesh.Trimesh(cup[0] + [60.0, 0.0, 0.0], cup[1], process=False)]
    )
    both.export(tmp_path / "two.stl")
    model_read = read_model(tmp_path / "two.stl")
    assert model_read.size[0] == pytest.approx(100.0)
    assert model_read.solid.volume() == pytest.approx(2.0 * volume(cup), rel=1e-6)


def test_a_surface_with_a_hole_in_it_is_refused(cup: Mesh, tmp_path: Path) -> None:
    for triangles in (cup[1][1:], np.concatenate([cup[1][:1, ::-1], cup[1][1:]])):
        path = saved((cup[0], triangles), tmp_path / "open.stl")
        with pytest.raises(
            ModelError, match=r"open\.stl: is not watertight \([1-9]\d* of its edges .* mend it"
        ) as caught:
            read_model(path)
        assert caught.value.reason == "open"


@pytest.mark.parametrize("suffix", [".stl", ".3mf", ".obj"])
@pytest.mark.parametrize("content", [b"", b"no model at all", b"\x00\xff" * 200, b"solid x\nfacet normal\n"])
def test_what_is_no_model_is_refused(suffix: str, content: bytes, tmp_path: Path) -> None:
    path = tmp_path / f"bad{suffix}"
    path.write_bytes(content)
    with pytest.raises(ModelError, match=r"bad\.") as caught:
        read_model(path)
    assert caught.value.reason in ("unreadable", "empty")


@pytest.mark.parametrize("suffix", [".stl", ".3mf", ".obj"])
def test_a_file_that_was_cut_short_is_refused(cup: Mesh, suffix: str, tmp_path: Path) -> None:
    path = saved(cup, tmp_path / f"cup{suffix}")
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    with pytest.raises(ModelError):
        read_model(path)


@pytest.mark.parametrize("height", ["nan", "inf", "1e300", "2e9"])
def test_coordinates_that_are_no_lengths_are_refused(height: str, tmp_path: Path) -> None:
    path = tmp_path / "odd.obj"
    tetrahedron = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 {}\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
    path.write_text(tetrahedron.format("1"))
    assert read_model(path).solid.volume() == pytest.approx(1 / 6)
    path.write_text(tetrahedron.format(height))
    with pytest.raises(ModelError, match=r"odd\.obj"):
        read_model(path)


def test_a_flat_thing_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "flat.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 3 2\n")
    with pytest.raises(ModelError, match=r"flat\.obj"):
        read_model(path)


def test_other_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=r"thing\.step: a solid is read from \.stl, \.3mf, \.obj"):
        read_model(tmp_path / "thing.step")
    with pytest.raises(FileNotFoundError):
        read_model(tmp_path / "absent.stl")


def test_what_is_too_large_is_refused_before_it_is_read(
    cup: Mesh, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with zipfile.ZipFile(tmp_path / "bomb.3mf", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("3D/3dmodel.model", b" " * 3_000_000)
    monkeypatch.setattr(model, "GREATEST_BYTES", 1 << 20)
    assert (tmp_path / "bomb.3mf").stat().st_size < 10_000
    with pytest.raises(ModelError, match="holds 2 MiB, more than 1") as caught:
        read_model(tmp_path / "bomb.3mf")
    assert caught.value.reason == "too-large"
    monkeypatch.setattr(model, "GREATEST_TRIANGLES", 10)
    with pytest.raises(ModelError, match="triangles, more than 10"):
        read_model(saved(cup, tmp_path / "cup.stl"))


def test_without_trimesh_the_extra_is_named(cup: Mesh, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = saved(cup, tmp_path / "cup.stl")

    def absent(name: str) -> object:
        raise ModuleNotFoundError(name=name)

    monkeypatch.setattr(importlib, "import_module", absent)
    with pytest.raises(MissingExtraError, match=r"riot-shapes\[print\]"):
        read_model(path)

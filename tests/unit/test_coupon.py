"""The test pieces of a printer, and profiles of machines."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

import pytest
import trimesh

from riot.cli import profiles
from riot.cli.main import main
from riot.errors import FormatError, ParameterError
from riot.fabricate.coupon import CLEARANCES_MM, INTERFERENCES_MM, coupon, joint_arms
from riot.fabricate.overhang import check_supports
from riot.fabricate.solid import Part, extruded, genus
from riot.fabricate.tuning import SLOPE
from riot.parameters import FabricationParameters
from riot.parameters.fabrication import PIVOTS


@pytest.mark.parametrize("pivot", sorted(set(PIVOTS) - {"in-place"}))
def test_every_part_is_one_solid_and_prints_without_supports(pivot: str) -> None:
    parameters = FabricationParameters(**PIVOTS[pivot])
    parts = coupon(parameters)
    for part in parts:
        assert len(part.solid.decompose()) == 1
        assert part.solid.genus() == genus(part.slabs)
        assert check_supports(part, parameters.layer_mm).failures == ()
    assert parts[0].solid.genus() == len(INTERFERENCES_MM)


def test_holes_are_as_the_numbers_say() -> None:
    bar, *arms = coupon(FabricationParameters())[: 1 + len(CLEARANCES_MM)]
    holes = sorted(ring for polygon in [bar.slabs[0].section] for ring in (2.0 * _radius(r) for r in polygon.interiors))
    assert holes == pytest.approx(sorted(3.0 - press for press in INTERFERENCES_MM), abs=0.01)
    for arm, clearance in zip(arms, CLEARANCES_MM, strict=True):
        assert arm.name == f"arm-{round(100 * clearance):02d}"
        through = min(_radius(ring) for slab in arm.slabs for ring in _rings(slab.section))
        assert through == pytest.approx(1.5 + clearance, abs=0.01)


@pytest.mark.parametrize("clearance", CLEARANCES_MM[::4])
def test_joints_in_place_have_the_clearance_that_their_numbers_say(clearance: float) -> None:
    parameters = FabricationParameters(**PIVOTS["in-place"], clearance_mm=clearance)
    arms = [Part(str(k), "piece", 1, slabs, extruded(slabs)) for k, slabs in enumerate(joint_arms(parameters))]
    for part in arms:
        assert len(part.solid.decompose()) == 1 and check_supports(part, parameters.layer_mm).failures == ()
    socket, pin = (part.solid for part in arms)
    assert clearance <= socket.min_gap(pin.rotate((0.0, 0.0, 30.0)), 0.7) < clearance + 0.01
    # Pulled up, down or sideways by the clearance along its slopes and two layers, the pin meets its socket.
    far = clearance / SLOPE + 2.0 * parameters.layer_mm
    for way in ((0.0, 0.0, far), (0.0, 0.0, -far), (far, 0.0, 0.0)):
        assert (socket ^ pin.translate(way)).volume() > 0.0


def _rings(section: object) -> list[object]:
    return list(max(getattr(section, "geoms", [section]), key=lambda part: part.area).interiors)[:1]


def _radius(ring: object) -> float:
    low, _, high, _ = ring.bounds  # type: ignore[attr-defined]
    return 0.5 * float(high - low)


class TestCommand:
    """`riot coupon`, and profiles of `riot coupon` and `riot print`."""

    def test_writes_plates_and_parts(self, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        out = tmp_path / "out"
        assert main(["coupon", "-o", str(out), "--profile", "prusa-mini", "--pivot", "filament"]) == 0
        assert "arms: clearances of 0.15, 0.25, 0.35, 0.45, 0.55 mm" in capsys.readouterr().out
        names = {path.name for path in out.iterdir()}
        assert names == {
            "bar.stl",
            *(f"arm-{k}.stl" for k in (15, 25, 35, 45, 55)),
            "cap.stl",
            "plate-1.3mf",
            "laser-coupon.svg",
        }
        assert all(trimesh.load_mesh(path).is_watertight for path in out.glob("*.stl"))
        assert main(["coupon", "-o", str(out)]) == 2
        assert main(["coupon", "-o", str(out), "--force"]) == 0
        assert "cap.stl" not in {path.name for path in out.iterdir()}

    def test_writes_joints_in_place(self, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        out = tmp_path / "out"
        assert main(["coupon", "-o", str(out), "--pivot", "in-place"]) == 0
        told = capsys.readouterr().out
        assert "joints: break each free, and turn it; clearances of 0.15" in told and "interferences" not in told
        assert "use it with --profile" in told and "----" not in told
        assert {path.name for path in out.glob("*.stl")} == {f"joint-{k}.stl" for k in (15, 25, 35, 45, 55)}
        mesh = trimesh.load_mesh(out / "joint-35.stl")
        assert mesh.is_watertight and mesh.body_count == 2 and mesh.bounds[0][2] == pytest.approx(0.0)

    def test_a_profile_that_is_not_there_is_told_with_those_that_are(
        self, tmp_path: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        assert main(["coupon", "-o", str(tmp_path / "out"), "--profile", "etch-a-sketch"]) == 2
        assert "choose of prusa-mini, prusa-mk3s, ender-3" in capsys.readouterr().err


def test_own_profiles_go_before_shipped_ones(tmp_path: Path) -> None:
    own = tmp_path / "makers.toml"
    own.write_text('[ender-3]\nclearance_mm = 0.3\npivot = "filament"\n[odd]\nspeed = 3\n[twist]\npivot = "string"\n')
    assert profiles.profile("ender-3", own) == {"clearance_mm": 0.3, "pivot": "filament"}
    assert profiles.profile("prusa-mini", own)["bed_width_mm"] == 180
    for name, words in (("odd", r"\[odd\] sets speed; parameters are"), ("twist", "choose one of printed, filament")):
        with pytest.raises(FormatError, match=words):
            profiles.profile(name, own)
    with pytest.raises(ParameterError, match=r"there is no 'none'; choose of prusa-mini"):
        profiles.profile("none", own)
    own.write_text("[ender-3\n")
    with pytest.raises(FormatError, match="is no TOML"):
        profiles.profile("ender-3", own)


def test_profiles_of_a_laser_and_its_material_go_together(tmp_path: Path) -> None:
    own = tmp_path / "makers.toml"
    own.write_text("[measured]\nkerf_mm = 0.12\n")
    assert profiles.profile("k40,plywood-3mm,measured", own) == {
        "bed_width_mm": 310,
        "bed_depth_mm": 210,
        "sheet_mm": 3.0,
        "kerf_mm": 0.12,
    }
    with pytest.raises(ParameterError, match="there is no ' plywood-3mm'"):
        profiles.profile("k40, plywood-3mm", own)


@pytest.mark.parametrize("name", profiles.shipped_profiles())
def test_shipped_profiles_are_parameters_with_sources(name: str, tmp_path: Path) -> None:
    kind = profiles.shipped_profiles()[name]["kind"]
    values = profiles.profile(name, tmp_path / "none.toml")
    assert FabricationParameters(**values)
    wanted = {"sheet_mm", "kerf_mm"} if kind == "material" else {"bed_width_mm", "bed_depth_mm"}
    assert wanted <= set(values) and kind in profiles.KINDS
    text = (resources.files("riot.cli") / profiles.FILE).read_text(encoding="utf-8")
    source = text.split(f"[{name}]\n")[1].splitlines()[0]
    assert source.startswith(("# https://", "# The same"))

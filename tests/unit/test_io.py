"""Result files: content against the solution, and never half a file."""

from __future__ import annotations

import csv
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ancf
from ancf import io, surface
from ancf.io import RESULT_FILES, result_text, write_result
from ancf.surface import rod_surface

E_MODULUS, NU, RADIUS, LENGTH = 1e6, 0.3, 0.01, 0.4


def solved(material: dict[str, Any] | None = None, **tables: Any) -> ancf.Solution:
    rod = {
        "name": "arm",
        "length": LENGTH,
        "elements": 4,
        "section": {"shape": "circle", "radius": RADIUS},
        "material": {"young_modulus": E_MODULUS, "poisson_ratio": NU, **(material or {})},
        "base": {"position": [1, 2, 3], "x_axis": [0, 0, 1], "y_axis": [0, 1, 0]},
    }
    rod.update(tables.pop("rod", {}))
    return ancf.solve(ancf.scene_from_dict({"rod": [rod], **tables}))


@pytest.fixture(scope="module")
def solution() -> ancf.Solution:
    """An arm along Z that is pulled aside and bent: every section force is at work."""
    return solved(force=[{"value": [0.02, 0.05, 0.3]}], moment=[{"value": [0.004, 0.002, 0.001]}])


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_all_files_are_written(solution: ancf.Solution, tmp_path: Path):
    result = write_result(tmp_path / "new" / "out", solution)
    assert sorted(contents(tmp_path / "new" / "out")) == sorted(RESULT_FILES)
    assert json.loads((tmp_path / "new" / "out" / "result.json").read_text()) == result
    assert result["status"] == "converged"
    again = ancf.resume(solution.scene, tmp_path / "new" / "out" / "state.npz")
    np.testing.assert_allclose(again.tip("arm").position, solution.tip("arm").position, rtol=1e-9)


def test_csv_holds_section_forces_in_both_frames(solution: ancf.Solution, tmp_path: Path):
    write_result(tmp_path, solution)
    with (tmp_path / "result.csv").open(newline="") as file:
        header, *rows = list(csv.reader(file))
    assert header[:3] == ["rod", "at [-]", "x [m]"]
    assert all(name.endswith(("[-]", "[m]", "[N]", "[N m]")) for name in header[1:])
    assert {row[0] for row in rows} == {"arm"}
    table = {name: np.array([float(row[i]) for row in rows]) for i, name in enumerate(header) if i > 0}
    # Equilibrium: the section force of a rod loaded at its end is the load, everywhere.
    for axis, load in zip("xyz", (0.02, 0.05, 0.3), strict=True):
        np.testing.assert_allclose(table[f"force_{axis} [N]"], load, rtol=1e-6)
    # The last section is turned little from the first only in its own axes: norms agree, components differ.
    local = np.stack([table["axial_force [N]"], table["shear_y [N]"], table["shear_z [N]"]])
    np.testing.assert_allclose(np.linalg.norm(local, axis=0), np.linalg.norm([0.02, 0.05, 0.3]), rtol=1e-6)
    # At the clamp the section axes are those of the base: x = Z, y = Y, z = -X.
    np.testing.assert_allclose(local[:, 0], [0.3, 0.05, -0.02], atol=0.01)
    assert table["x [m]"][-1] < LENGTH


def test_vtu_holds_the_deformed_surface(solution: ancf.Solution, tmp_path: Path):
    meshio = pytest.importorskip("meshio")
    write_result(tmp_path, solution)
    mesh = meshio.read(tmp_path / "result.vtu")
    (cells,) = mesh.cells
    assert cells.type == "quad"
    assert set(mesh.point_data) == {"displacement", "strain", "stress", "rod"}
    assert cells.data.max() == len(mesh.points) - 1
    ring = mesh.points[-surface.OUTLINE_POINTS :]
    np.testing.assert_allclose(ring.mean(axis=0), solution.tip("arm").position, atol=1e-12)
    first = (mesh.points - mesh.point_data["displacement"])[: surface.OUTLINE_POINTS]
    np.testing.assert_allclose(np.linalg.norm(first - [1, 2, 3], axis=1), RADIUS, rtol=1e-12)


def test_stretched_rod_has_uniaxial_stress():
    force = 20.0
    free = {"supports": [{"at": 0.0, "kind": "free_section_clamp"}]}  # free to contract: a uniform state
    result = rod_surface(solved(rod=free, force=[{"value": [0, 0, force]}]), "arm")
    # Saint Venant-Kirchhoff in uniaxial stress: E_xx = (s^2 - 1)/2, S_xx = E E_xx, P = s S_xx = force/area,
    # E_yy = -nu E_xx.
    area = np.pi * RADIUS**2
    stretch = np.roots([0.5 * E_MODULUS, 0.0, -0.5 * E_MODULUS, -force / area])
    (s,) = (v.real for v in stretch if abs(v.imag) < 1e-12 and v.real > 1.0)
    strain = 0.5 * (s**2 - 1.0)
    everywhere = (*result.at.shape, 24, 3, 3)
    expected = np.broadcast_to(np.diag([strain, -NU * strain, -NU * strain]), everywhere)
    np.testing.assert_allclose(result.strain, expected, atol=1e-9)
    expected = np.broadcast_to(np.diag([E_MODULUS * strain, 0.0, 0.0]), everywhere)
    np.testing.assert_allclose(result.stress, expected, atol=1e-9 * E_MODULUS)


def test_twisted_rod_has_shear_stress():
    torque = 0.002
    result = rod_surface(solved(moment=[{"value": [0, 0, torque]}]), "arm")
    middle = len(result.at) // 2
    # Coulomb: tau = M r/J on the skin, J = pi r^4/2; strains are 0.3 % here. Tensor strain is tau/(2 G).
    tau = torque * RADIUS / (0.5 * np.pi * RADIUS**4)
    shear = np.hypot(result.stress[middle, :, 0, 1], result.stress[middle, :, 0, 2])
    np.testing.assert_allclose(shear, tau, rtol=5e-3)
    gamma = 2.0 * np.hypot(result.strain[middle, :, 0, 1], result.strain[middle, :, 0, 2])
    np.testing.assert_allclose(gamma, tau / (E_MODULUS / (2 * (1 + NU))), rtol=5e-3)


def test_surface_of_a_fine_rod_is_thinned(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(surface, "MOST_RINGS", 5)
    result = rod_surface(solved(force=[{"value": [0.01, 0, 0]}]), "arm")
    assert result.position.shape == (5 + 2, 24, 3)
    assert result.quads.shape == (6 * 24, 4)


@pytest.mark.parametrize("failing", ["_write_csv", "_write_vtu", "result_text", "os.replace"])
@pytest.mark.parametrize("error", [OSError("disk full"), KeyboardInterrupt()])
def test_interrupted_write_leaves_the_old_files_whole(
    failing: str,
    error: BaseException,
    solution: ancf.Solution,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
):
    write_result(tmp_path, solution)
    before = contents(tmp_path)

    def broken(path: object, *_: object) -> None:
        if isinstance(path, Path) and failing != "os.replace":
            path.write_text("half")
        raise error

    target = io if failing != "os.replace" else io.os
    monkeypatch.setattr(target, failing.removeprefix("os."), broken)
    with pytest.raises(type(error)):
        write_result(tmp_path, solution)
    assert contents(tmp_path) == before


def test_without_meshio_the_rest_is_written(
    solution: ancf.Solution, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    write_result(tmp_path, solution)
    monkeypatch.setitem(sys.modules, "meshio", None)
    result = write_result(tmp_path, solution)
    assert "result.vtu was not written: it needs meshio" in result["warnings"][-1]
    assert json.loads((tmp_path / "result.json").read_text())["warnings"] == result["warnings"]
    assert not (tmp_path / "result.vtu").exists()  # the former one belongs to another result


def test_result_text_has_no_nan():
    with pytest.raises(ValueError, match="JSON"):
        result_text({"residual": float("nan")})

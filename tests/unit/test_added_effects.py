"""Effects of other packages: found by entry point, read, solved, and refused in five parts.

`tests/added_package` is such a package as pip would install it: a module and a dist-info folder. Each test
runs in an interpreter of its own, so that what is imported there can be seen.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

PACKAGE = Path(__file__).parents[1] / "added_package"
PREAMBLE = """
import sys
import numpy as np
import ancf
from ancf.errors import SceneError

ROD = {"name": "arm", "length": 0.4, "elements": 6, "section": {"shape": "circle", "radius": 0.004},
       "material": {"young_modulus": 1e6, "poisson_ratio": 0.3}}
BENT = {"rod": [ROD], "force": [{"value": [0, 1e-4, 0]}]}

def refusal(scene):
    try:
        ancf.scene_from_dict(scene)
    except SceneError as error:
        return str(error)
    raise AssertionError("not refused")
"""


def run(code: str, *paths: Path) -> str:
    """Output of Python code with `paths` in front of sys.path."""
    setup = "".join(f"import sys; sys.path.insert(0, {str(path)!r})\n" for path in paths)
    done = subprocess.run([sys.executable, "-c", setup + PREAMBLE + code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def brought(folder: Path, name: str, module: str, text: str, table: str = "current") -> Path:
    """A package of one module with an entry point for `table`, in a folder for sys.path."""
    info = folder / f"{name}-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(f"[ancf.effects]\n{table} = {module}\n")
    (folder / f"{module}.py").write_text(text)
    return folder


def test_an_added_effect_is_solved_like_any_other():
    """Drag on a stiff rod across the current: c u^2 L, c = 1/2 rho C_d 2R, moment half that times L
    (Morison's drag on a straight cylinder); its balance, exact tangent and record."""
    run(
        """
scene = ancf.scene_from_dict({"rod": [ROD], "current": [{"velocity": [0, 1e-3, 0], "density": 800.0}]})
solution = ancf.solve(scene)
assert solution.status == "converged"
drag = 0.5 * 800.0 * 1.2 * 0.008 * 1e-3**2 * 0.4
found = solution.balance().applied["current"]
np.testing.assert_allclose(found.force, [0, drag, 0], atol=1e-3 * drag)
force, moment = solution.reaction()
np.testing.assert_allclose(moment, [0, 0, -0.5 * drag * 0.4], atol=1e-3 * drag * 0.4)
assert solution.balance().relative < 1e-10 + solution.residual_floor
assert solution.as_dict()["effects"]["current"]["calls"] > 1
assert not solution.model.conservative

strong = ancf.scene_from_dict({**BENT, "current": [{"velocity": [0.02, 0.08, 0.03]}]})
solution = ancf.solve(strong)
assert solution.status == "converged" and solution.steps == 1
model, q = solution.model, solution.q
rng = np.random.default_rng(0)
way = rng.uniform(-1, 1, model.n) * model.unit
effect = next(e for e in model.effects if e.name == "current")
block = lambda q: q[effect.dofs].reshape(len(effect.dofs), -1, 3)
K = effect.force_and_tangent(block(q))[1]
change = (effect.force(block(q + 1e-6 * way)) - effect.force(block(q - 1e-6 * way))) / 2e-6
exact = np.einsum("mij,mj->mi", K, way[effect.dofs]).reshape(change.shape)
np.testing.assert_allclose(exact, change, atol=1e-7 * abs(change).max())
batch = ancf.solve_batch(strong, forces=[[0, 1e-4, 0], [0, 2e-4, 0]])
assert batch.engine == "numpy" and (batch.status == "converged").all()
np.testing.assert_allclose(batch.poses[0, :, 0], solution.tip().position, atol=1e-9)
""",
        PACKAGE,
    )


def test_a_single_table_is_a_list_of_one():
    run(
        """
one = ancf.scene_from_dict({"rod": [ROD], "current": {"velocity": [0, 0.01, 0]}})
assert len(one.added) == 1 and len(one.added[0].records) == 1
""",
        PACKAGE,
    )


def test_check_lists_it(tmp_path):
    (tmp_path / "scene.toml").write_text(
        'rod = [{ length = 0.4, elements = 4, section = { shape = "circle", radius = 0.004 }, '
        "material = { young_modulus = 1e6, poisson_ratio = 0.3 } }]\ncurrent = [{ velocity = [0, 0.1, 0] }]\n"
    )
    out = run(
        f"""
import json
from ancf.cli import main
assert main(["check", {str(tmp_path / "scene.toml")!r}]) == 0
assert main(["check", {str(tmp_path / "scene.toml")!r}, "--json"]) == 0
""",
        PACKAGE,
    )
    assert '"current"' in out


def test_a_scene_without_it_neither_looks_for_it_nor_imports_it():
    run(
        """
import importlib.metadata
def fail(**_): raise AssertionError("entry points looked up")
importlib.metadata.entry_points = fail
assert ancf.solve(ancf.scene_from_dict(BENT)).status == "converged"
assert "current_effect" not in sys.modules and "ancf.added_effects" in sys.modules
""",
        PACKAGE,
    )


def test_refusals(tmp_path):
    """Unknown without the package, misspelt with it; its own refusals name file and key."""
    code = """
text = refusal({"rod": [ROD], "current": [{"velocity": [0, 1, 0]}]})
assert text.startswith("Unknown key 'current'."), text
"""
    run(code)
    run(
        """
text = refusal({"rod": [ROD], "curent": [{"velocity": [0, 1, 0]}]})
assert 'did you mean "current"?' in text, text
text = refusal({"rod": [ROD], "current": [{"velocity": [0, 1, 0], "density": -1.0}]})
assert "scene: current[0].density" in text and "must be > 0" in text, text
text = refusal({"rod": [ROD], "current": [{"velocity": [0, 1, 0], "rod": "leg"}]})
assert "current[0].rod" in text, text
""",
        PACKAGE,
    )


def test_broken_packages_are_refused(tmp_path):
    for number, (text, words) in enumerate(
        (
            ("raise RuntimeError('no licence')", "RuntimeError: no licence"),
            ("def read(table, rods): ...", "it has no build"),
            ("import a_package_that_is_not_there", "ModuleNotFoundError"),
        )
    ):
        folder = tmp_path / str(number)
        folder.mkdir()
        brought(folder, "broken", "broken_effect", text)
        run(
            f"""
text = refusal({{"rod": [ROD], "current": [{{}}]}})
assert text.startswith('The effect "current" cannot be loaded.') and {words!r} in text, text
assert "broken 1.0" in text and text.count("\\n") == 4, text
assert ancf.solve(ancf.scene_from_dict(BENT)).status == "converged"
""",
            folder,
        )


def test_two_packages_of_one_name_are_refused(tmp_path):
    brought(tmp_path, "second", "second_effect", "")
    run(
        """
text = refusal({"rod": [ROD], "current": [{}]})
assert text.startswith('Two packages bring the effect "current".'), text
""",
        tmp_path,
        PACKAGE,
    )


def test_tables_of_this_package_cannot_be_replaced(tmp_path):
    brought(tmp_path, "other", "other_force", "raise RuntimeError", table="force")
    run(
        """
scene = ancf.scene_from_dict({**BENT, "current": [{"velocity": [0, 0.01, 0]}]})
assert len(scene.forces) == 1 and [added.table for added in scene.added] == ["current"]
""",
        tmp_path,
        PACKAGE,
    )

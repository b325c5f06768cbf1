"""Four rooms, one direction (architecture.md), read from the import statements; sizes, docstrings, start-up
imports.
"""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
ROOMS = ("ancf", "reference", "validation", "surrogate")
BORDER = {"typer", "rich", "pint", "meshio", "pyvista", "matplotlib", "trame_vtk", "PIL"}
HEAVY = ("torch", "numba", "skfem", "pyvista", "matplotlib", "meshio", "pint", "trame_vtk", "PIL")

# room -> third-party packages that it may import, and other rooms (architecture.md, "Four rooms, one
# direction")
ALLOWED = {
    "ancf": {"numpy", "scipy", "array_api_compat"},
    "reference": {"numpy", "scipy", "skfem", "meshio", "felupe"},  # felupe: an optional peer
    "validation": {
        "numpy",
        "scipy",
        "typer",
        "rich",
        "matplotlib",
        "jinja2",
        "markupsafe",  # part of jinja2: markup that is not escaped again
        "skfem",
        "meshio",
        "ancf",
        "reference",
        "exudyn",  # an optional peer, as felupe
    },
    "surrogate": {
        "numpy",
        "scipy",
        "torch",
        "typer",
        "rich",
        "matplotlib",
        "distributed",  # the extra "cluster"
        "pyarrow",  # the extra "parquet"
        "onnx",  # an export
        "ancf",
        "validation",
    },
}
# of ancf only these touch the border libraries ("scene.py, cli.py, io.py, view.py may load the border
# libraries")
BORDER_MODULES = {"cli.py", "cli_solve.py", "io.py", "view.py", "units.py", "scene_file.py", "surface.py"} | {
    f"view_{part}.py" for part in ("3d", "marks", "page", "skin")
}
# The compiled batch kernel, loaded when `solve_batch` takes it.
COMPILED_MODULES = {"fused_blocks.py", "fused_cuda.py", "fused_kernel.py", "lane_column.py", "lanes.py"}
MOST_LINES = 400


def modules(room):
    return sorted((ROOT / room).rglob("*.py"))


def imports(path):
    """(top-level package, full name, line, at module level?) of every import statement."""
    tree = ast.parse(path.read_text())
    top = set(map(id, tree.body))
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            names = [node.module or ""]
        elif isinstance(node, ast.ImportFrom):
            names = [path.relative_to(ROOT).parts[0] + "."]
        else:
            continue
        for name in names:
            yield name.split(".")[0], name, node.lineno, id(node) in top


ALL = [pytest.param(room, path, id=str(path.relative_to(ROOT))) for room in ROOMS for path in modules(room)]


@pytest.mark.parametrize(("room", "path"), ALL)
def test_imports_run_in_one_direction(room, path):
    allowed = ALLOWED[room] | {room} | set(sys.stdlib_module_names)
    if room == "ancf" and path.name in BORDER_MODULES:
        allowed |= BORDER
    if room == "ancf" and path.name in COMPILED_MODULES:
        allowed |= {"numba", "llvmlite"}
    wrong = [f"line {line}: {name}" for package, name, line, _ in imports(path) if package not in allowed]
    assert not wrong, f"{path.relative_to(ROOT)} imports {wrong}"


@pytest.mark.parametrize("path", modules("surrogate"), ids=lambda p: p.name)
def test_the_surrogate_sees_only_the_certificate(path):
    wrong = [
        n for p, n, _, _ in imports(path) if p == "validation" and not n.startswith("validation.certificate")
    ]
    assert not wrong


@pytest.mark.parametrize(("room", "path"), ALL)
def test_heavy_packages_load_when_used(room, path):
    """Inside functions only; scikit-fem at the top of the solid modules of reference/."""
    heavy = set(HEAVY) - (
        {"skfem", "meshio"} if room == "reference" else {"torch"} if room == "surrogate" else set()
    )
    if path.name in COMPILED_MODULES:
        heavy -= {"numba"}
    wrong = [f"line {line}: {name}" for package, name, line, top in imports(path) if top and package in heavy]
    assert not wrong, f"{path.relative_to(ROOT)} imports {wrong} at the top"


@pytest.mark.parametrize(("room", "path"), ALL)
def test_modules_are_short(room, path):
    assert len(path.read_text().splitlines()) <= MOST_LINES


@pytest.mark.parametrize(("room", "path"), ALL)
def test_public_names_have_docstrings(room, path):
    tree = ast.parse(path.read_text())
    assert ast.get_docstring(tree), f"{path.name} has no docstring"
    found = []
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef):
            children = [c for c in node.body if isinstance(c, ast.FunctionDef)]
        elif isinstance(node, ast.Module):
            children = [c for c in node.body if isinstance(c, ast.FunctionDef | ast.ClassDef)]
        else:
            continue
        if isinstance(node, ast.ClassDef) and node.name.startswith("_"):
            continue
        found += [c.name for c in children if not c.name.startswith("_") and not ast.get_docstring(c)]
    assert not found


def test_no_room_for_leftovers():
    """architecture.md: no utils, no common, no helper, manager, base, misc; no src/."""
    banned = {"utils", "common", "helper", "helpers", "manager", "base", "misc"}
    assert not [path for room in ROOMS for path in modules(room) if path.stem in banned]
    assert not (ROOT / "src").exists()


@pytest.mark.parametrize("name", ["ancf", "validation.properties"])
def test_import_stays_light(name):
    """interface.md: `import ancf` loads none of torch, scikit-fem, pyvista, matplotlib, meshio, pint."""
    code = f"import sys, {name}; print([m for m in {HEAVY!r} if m in sys.modules])"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    assert out.stdout.strip() == "[]"


def test_solving_stays_light():
    """A whole solve needs numpy and scipy only."""
    code = (
        "import sys, ancf; s = ancf.solve(ancf.scene_from_dict({'rod': [{'length': 1.0, 'elements': 4,"
        " 'section': {'shape': 'circle', 'radius': 0.02}, 'material': {'law': 'saint-venant-kirchhoff',"
        " 'young_modulus': 1e6, 'poisson_ratio': 0.3}}], 'moment': [{'value': [0.0, 0.0, 0.01]}]}));"
        f" print(s.status, [m for m in {HEAVY!r} if m in sys.modules])"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    assert out.stdout.strip() == "converged []"

"""The wheel: built, installed into an empty folder, imported from another one, package data included."""

import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
ROOMS = ("ancf", "reference", "validation", "surrogate")
DATA = {".toml", ".j2", ".css", ".json", ".html"}  # what the rooms keep beside their modules


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    pytest.importorskip("hatchling")
    folder = tmp_path_factory.mktemp("wheel")
    command = [
        sys.executable,
        "-m",
        "pip",
        "wheel",
        "--no-build-isolation",
        "--no-deps",
        "-q",
        "-w",
        str(folder),
        str(ROOT),
    ]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    (found,) = folder.glob("ancf-*.whl")
    return found


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory):
    target = tmp_path_factory.mktemp("site")
    command = [
        sys.executable,
        "-m",
        "pip",
        "install",
        "--no-deps",
        "--no-index",
        "-q",
        "--target",
        str(target),
        str(wheel),
    ]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return target


def tracked():
    """Files of the rooms that git knows or would know."""
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard", *ROOMS]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
    if done.returncode != 0:
        pytest.skip("not a git checkout")
    return {name for name in done.stdout.splitlines() if (ROOT / name).is_file()}


def test_every_module_and_data_file_is_in_the_wheel(wheel):
    inside = set(zipfile.ZipFile(wheel).namelist())
    wanted = {name for name in tracked() if Path(name).suffix in {".py", *DATA}}
    assert wanted
    assert not wanted - inside
    assert not [name for name in inside if name.split("/")[0] not in ROOMS and ".dist-info/" not in name]


def test_it_imports_from_another_folder(installed, tmp_path):
    code = (
        "import ancf, reference.analytic, validation.properties, importlib.resources as r;"
        "print(ancf.__file__);"
        "print(sum(f.name.endswith('.toml') for f in r.files('validation').joinpath('cases').iterdir()))"
    )
    command = [sys.executable, "-c", f"import sys; sys.path.insert(0, {str(installed)!r}); {code}"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    where, cases = done.stdout.split()
    assert Path(where).is_relative_to(installed)
    expected = len(list((ROOT / "validation" / "cases").glob("*.toml")))
    assert int(cases) == expected > 0


def test_it_solves_without_the_checkout(installed, tmp_path):
    scene = tmp_path / "scene.toml"
    scene.write_text(
        "[[rod]]\nlength = 1.0\nelements = 4\nsection = { shape = 'circle', radius = 0.02 }\n"
        "material = { law = 'saint-venant-kirchhoff', young_modulus = 1e6, poisson_ratio = 0.3 }\n"
        "[[moment]]\nvalue = [0, 0, 0.01]\n"
    )
    code = (
        f"import sys; sys.path.insert(0, {str(installed)!r}); import ancf;"
        f"print(ancf.solve(ancf.load_scene({str(scene)!r})).status)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path)
    assert done.stdout.strip() == "converged", done.stderr


def test_the_shipped_certificate_holds_there_too(installed, tmp_path):
    """Data files included: without its cases the package would not be what was certified."""
    pytest.importorskip("skfem")
    code = (
        f"import sys; sys.path.insert(0, {str(installed)!r}); from validation.certificate import verify;"
        "found = verify(); print(found.path); print(found.valid, found.reasons)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path)
    where, verdict = done.stdout.splitlines()
    assert Path(where).is_relative_to(installed)
    assert verdict == "True []"

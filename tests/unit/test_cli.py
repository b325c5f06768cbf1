"""The command line: exit codes, one JSON object on standard output, messages on standard error."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from ancf import cli
from ancf.cli import main

EXAMPLES = Path(__file__).parents[2] / "examples"
ROD = """
[[rod]]
length = 0.4
elements = {elements}
section = {{ shape = "circle", radius = 0.004 }}
material = {{ young_modulus = 1e6, poisson_ratio = 0.3 }}
"""
# E I (pi/2)/L with E = 1e6 Pa, I = pi r^4/4, r = 4 mm, L = 0.4 m
MOMENT = "[[moment]]\nvalue = [0, 0, 7.895683520871486e-4]\n"
IMPOSSIBLE = "[[force]]\nvalue = [0, 1e300, 0]\n"


@pytest.fixture
def bent(tmp_path: Path) -> Path:
    """A rod bent to a quarter circle."""
    path = tmp_path / "bent.toml"
    path.write_text('title = "Quarter [circle]"\n' + ROD.format(elements=8) + MOMENT)
    return path


@pytest.fixture
def impossible(tmp_path: Path) -> Path:
    """A rod under a load for which there is no equilibrium in float64."""
    path = tmp_path / "impossible.toml"
    path.write_text(ROD.format(elements=4) + IMPOSSIBLE)
    return path


def refused(capsys: pytest.CaptureFixture[str], *args: str) -> str:
    """Run a refused command: exit code 2, nothing on standard output, five parts on standard error."""
    assert main(args) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert [line.split(":")[0].strip() for line in captured.err.splitlines()[-4:]] == [
        "where",
        "value",
        "cause",
        "try",
    ]
    return captured.err


def test_solve_prints_one_json_object(bent: Path, capsys: pytest.CaptureFixture[str]):
    assert main(["solve", str(bent), "--json"]) == 0
    captured = capsys.readouterr()
    result = json.loads(captured.out)
    assert captured.err == ""
    assert (result["schema"], result["status"], result["title"]) == (1, "converged", "Quarter [circle]")
    assert set(result["effects"]) == {"elastic", "moment"}
    # Thin limit: tip at L sin(t)/t, t = pi/2; finite strain changes it by about 1.4 (kappa R)^2 = 3e-4.
    assert result["rods"]["rod"]["tip"]["position"][0] == pytest.approx(0.4 * 2 / math.pi, rel=1e-3)


def test_solve_tells_people_on_standard_error(bent: Path, capsys: pytest.CaptureFixture[str]):
    assert main(["solve", str(bent)]) == 0
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "Quarter [circle]" in captured.err
    assert "converged" in captured.err
    assert "0.2545" in captured.err


def test_several_scenes_give_one_object_and_a_folder_each(
    bent: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    other = tmp_path / "other.toml"
    other.write_text(ROD.format(elements=4))
    out = tmp_path / "out"
    assert main(["solve", str(bent), str(other), "--json", "--out", str(out)]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["schema"] == 1
    assert [result["unknowns"] for result in printed["results"]] == [8 * 18, 4 * 18]
    for name, result in zip(("bent", "other"), printed["results"], strict=True):
        assert json.loads((out / name / "result.json").read_text()) == result


def test_no_equilibrium_is_exit_code_3_with_a_result(
    impossible: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    assert main(["solve", str(impossible), "--json", "--out", str(tmp_path / "out")]) == 3
    captured = capsys.readouterr()
    result = json.loads(captured.out)
    assert result["status"] != "converged"
    assert result["reason"]
    assert result == json.loads((tmp_path / "out" / "result.json").read_text())
    assert "No equilibrium" in captured.err and "  try:" in captured.err
    assert "Traceback" not in captured.err


def test_check_lists_what_would_be_simulated(bent: Path, capsys: pytest.CaptureFixture[str]):
    bent.write_text(ROD.format(elements=16) + MOMENT)  # fewer would be solved in full
    assert main(["check", str(bent), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["effects"] == ["elastic", "moment"]
    assert found["unknowns"] == 16 * 18  # 33 nodes of 9 components, one clamped
    assert found["reductions"] == [
        "planar: rods and loads stay in the plane across (0, 0, 1), 160 of 288 unknowns are solved for",
        "symmetric: on shapes in the plane the loads have a potential, Cholesky factors replace LU",
    ]
    assert found["rods"]["rod"]["section"] == {"shape": "circle", "radius": 0.004}
    advice = found["advice"]
    assert (advice["accuracy"], advice["accuracy_source"], advice["state"]) == (
        1e-3,
        "default",
        "equilibrium",
    )
    assert [(i["effect"], i["verdict"]) for i in advice["listed"]] == [("moment", "matters")]
    assert [i["effect"] for i in advice["missing"]] == ["gravity", "contact with itself"]
    assert [i["effect"] for i in advice["choices"]] == ["moment direction", "law", "mesh", "sections"]
    assert main(["check", str(bent)]) == 0
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "effects:    elastic, moment" in captured.err
    assert "reduction:  planar: rods and loads stay in the plane" in captured.err
    assert "advice at 0.001 of the length (default" in captured.err
    rows = {line.split("  ")[2]: line for line in captured.err.splitlines() if line.startswith("    ")}
    assert "yes" in rows["moment"] and rows["moment"].endswith("needed")
    assert "would matter: list [gravity] and give the density" in rows["gravity"]


def test_check_names_law_element_and_known_limits(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    """A linear section in the continuum locks: (1 - nu)/((1 + nu)(1 - 2 nu)) = 3.793 at nu = .45."""
    rubber = 'law = "neo-hookean", young_modulus = 1e6, poisson_ratio = 0.45'
    text = (
        '[[rod]]\nlength = 0.4\nelements = 2\nelement = "{element}"\nformulation = "continuum"\n'
        'section = {{ shape = "circle", radius = 0.01 }}\nmaterial = {{ {rubber} }}\n'
    )
    scene = tmp_path / "scene.toml"
    for element, factors in (("3363", []), ("3333", ["3.793"])):
        scene.write_text(text.format(element=element, rubber=rubber))
        assert main(["check", str(scene), "--json"]) == 0
        found = json.loads(capsys.readouterr().out)
        described = found["rods"]["rod"]
        assert (described["element"], described["formulation"]) == (element, "continuum")
        assert described["material"] == {
            "law": "neo-hookean",
            "young_modulus": 1e6,
            "poisson_ratio": 0.45,
        }
        assert [factor in text for factor, text in zip(factors, found["warnings"], strict=True)] == [
            True
        ] * len(factors)
        assert main(["check", str(scene)]) == 0
        shown = capsys.readouterr().err
        assert f"2 x {element} continuum" in shown and "neo-hookean: young_modulus = 1e+06" in shown
        assert ("warning:" in shown) == bool(factors)


@pytest.mark.parametrize(
    ("args", "expected"),
    [
        (["slove", "x.toml"], 'did you mean "solve"?'),
        (["zzz"], "see ancf --help"),
        (["solve"], "Missing argument"),
        (["solve", "x.toml", "--jsn"], "No such option"),
        (["--jsn"], "No such option"),
        (["solve", "none.toml"], "no such file"),
        (["check", "none.toml"], "no such file"),
        (["check", "a.toml", "b.toml"], "unexpected extra argument"),
    ],
)
def test_wrong_command_lines_are_refused(args: list[str], expected: str, capsys: pytest.CaptureFixture[str]):
    assert expected in refused(capsys, *args)


def test_wrong_scene_writes_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    scene = tmp_path / "bad.toml"
    scene.write_text(ROD.format(elements=0))
    error = refused(
        capsys, "solve", str(scene), "--json", "--out", str(tmp_path / "o"), "--plot", str(tmp_path / "p.png")
    )
    assert f"{scene}: rod[0].elements" in error
    assert list(tmp_path.iterdir()) == [scene]


def test_one_bad_scene_among_several_stops_all(
    bent: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    assert "no such file" in refused(capsys, "solve", str(bent), "none.toml", "--out", str(tmp_path / "o"))
    assert not (tmp_path / "o").exists()


def test_impossible_destinations_are_refused_before_solving(
    bent: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    def forbidden(*_: object) -> None:
        raise AssertionError("solved")

    monkeypatch.setattr("ancf.solver.solve", forbidden)
    file = tmp_path / "file"
    file.write_text("")
    scene = str(bent)
    assert "is a file" in refused(capsys, "solve", scene, "--out", str(file))
    assert "is a file" in refused(capsys, "solve", scene, "--out", str(file / "below"))
    assert ".png, .svg, .pdf" in refused(capsys, "solve", scene, "--plot", str(tmp_path / "p.gif"))
    assert "no folder" in refused(capsys, "solve", scene, "--plot", str(tmp_path / "none" / "p.png"))
    (tmp_path / "p.png").mkdir()
    assert "a directory" in refused(capsys, "solve", scene, "--plot", str(tmp_path / "p.png"))
    assert "is not .html" in refused(capsys, "solve", scene, "--view", str(tmp_path / "v.png"))
    assert "no folder" in refused(capsys, "solve", scene, "--view", str(tmp_path / "none" / "v.html"))
    (tmp_path / "v.html").mkdir()
    assert "a directory" in refused(capsys, "solve", scene, "--view", str(tmp_path / "v.html"))
    assert "shows one scene" in refused(capsys, "solve", scene, scene, "--view", str(tmp_path / "w.html"))
    assert "more than once" in refused(capsys, "solve", scene, scene, "--out", str(tmp_path / "o"))


def test_a_folder_in_the_place_of_a_result_is_refused_first(
    bent: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    (tmp_path / "out" / "result.json").mkdir(parents=True)
    error = refused(capsys, "solve", str(bent), "--json", "--out", str(tmp_path / "out"))
    assert "taken by a folder" in error
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["result.json"]


def test_full_disk_is_no_traceback(
    bent: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("ancf.io._write_csv", full)
    error = refused(capsys, "solve", str(bent), "--json", "--out", str(tmp_path / "out"))
    assert "cannot be written" in error and "No space left" in error
    assert not list((tmp_path / "out").glob("result*"))


def test_help_lists_commands_without_loading_them(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    broken = EntryPoint("broken", "no_such_package.cli:run", "ancf.commands")
    installed = {**cli._installed(), "broken": broken}
    monkeypatch.setattr(cli, "_installed", lambda: installed)
    for args in ([], ["--help"]):
        assert main(args) == 0
        text = capsys.readouterr().out
        assert [name for name in ("solve", "check", "validate", "report", "broken") if f"\n  {name} " in text]
        assert "Exit codes" in text
    with pytest.raises(ModuleNotFoundError, match="no_such_package"):
        main(["broken"])


def test_missing_extra_is_named(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch):
    def missing(*_: object) -> None:
        raise ModuleNotFoundError("No module named 'skfem'", name="skfem.helpers")

    monkeypatch.setattr(cli, "_load", missing)
    assert "pip install 'ancf[reference]'" in refused(capsys, "report")


def test_bugs_are_not_hidden(bent: Path, monkeypatch: pytest.MonkeyPatch):
    def broken(*_: object) -> None:
        raise RuntimeError("a bug")

    monkeypatch.setattr("ancf.solver.solve", broken)
    with pytest.raises(RuntimeError, match="a bug"):
        main(["solve", str(bent)])


def test_figure_2_is_one_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    pytest.importorskip("matplotlib")
    scenes = [str(path) for path in sorted(EXAMPLES.glob("fig2-*.toml"))]
    assert len(scenes) == 4
    assert main(["solve", *scenes, "--plot", str(tmp_path / "fig2.svg")]) == 0
    text = (tmp_path / "fig2.svg").read_text()
    assert text.count('<g id="axes_') == 4
    assert [path.name for path in tmp_path.iterdir()] == ["fig2.svg"]
    # The paper's law locks (theory: Poisson locking at nu = 0.3 by 1.346); each of the four runs says so.
    assert capsys.readouterr().err.count("1.346") == 4


# --- the installed program ---------------------------------------------------------------------------------


def run(*args: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, "-m", "ancf.cli", *args]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, env=environment)


def test_program_refuses_without_traceback(tmp_path: Path):
    ended = run("solve", str(tmp_path))
    assert ended.returncode == 2
    assert ended.stdout == ""
    assert "Traceback" not in ended.stderr
    assert "it is a directory" in ended.stderr


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device that is always full")
def test_full_standard_output_is_no_traceback(bent: Path):
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    with open("/dev/full", "w") as full:
        command = [sys.executable, "-m", "ancf.cli", "solve", str(bent), "--json"]
        done = subprocess.run(
            command, stdout=full, stderr=subprocess.PIPE, text=True, timeout=60, env=environment
        )
    assert done.returncode == 2
    assert done.stderr.startswith("The standard output cannot be written.")
    assert "Traceback" not in done.stderr


def test_reader_that_leaves_early_is_no_error_of_ours(tmp_path: Path):
    long = tmp_path / "long.toml"  # more text than one buffer holds
    long.write_text(ROD.format(elements=60) + MOMENT)
    command = [sys.executable, "-m", "ancf.cli", "solve", str(long), "--json"]
    done = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert done.stdout is not None and done.stderr is not None
    done.stdout.close()
    said = done.stderr.read()
    assert (done.wait(60), said) == (cli.PIPE_CLOSED, "")
    done.stderr.close()


def test_help_loads_nothing_heavy():
    code = (
        "import sys, ancf\nfrom ancf.cli import main\n"
        "heavy = {'torch', 'skfem', 'pyvista', 'matplotlib', 'meshio', 'pint', 'scipy', 'rich'}\n"
        "assert main(['--help']) == 0 and main(['--version']) == 0 and main(['solve', '--help']) == 0\n"
        "found = heavy & set(sys.modules)\nassert not found, found\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60, stdout=subprocess.DEVNULL)


def test_solve_tells_people_of_stability(capsys: pytest.CaptureFixture[str]):
    """The column of the examples: 4.1 mN against (pi^2/4) E I/L^2 = 3.1006 mN, less 0.02 % for shear."""
    assert main(["solve", str(EXAMPLES / "buckled-column.toml")]) == 0
    told = " ".join(capsys.readouterr().err.split())
    assert "stable; critical points by load factor: bifurcation at 0.756" in told
    assert "(2 modes)" in told

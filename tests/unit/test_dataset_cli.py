"""`ancf dataset`: exit codes, one JSON object, options that exclude each other, shards."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from ancf.cli import main
from surrogate import gate, parquet, sweep
from surrogate.dataset import load
from tests.datasets import ID, stale, valid

DESIGNS = Path(__file__).parents[2] / "examples" / "designs"
DESIGN = """
title = "mine"
[[rod]]
length = 0.4
elements = 6
section = { shape = "circle", radius = 0.01 }
material = { young_modulus = 1e6, poisson_ratio = 0.3 }
[[moment]]
value = [0, 0, 0]
[design]
count = 300
vary = [{ load = "moment", component = "z", range = [0.001, 0.01] }]
"""


@pytest.fixture(autouse=True)
def _certified(monkeypatch):
    monkeypatch.setattr(gate, "verify", valid())


@pytest.fixture
def mine(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(DESIGN)
    return str(path)


def refused(capsys, *args, code=2):
    """The message of a refused command: nothing on standard output, five parts on standard error."""
    assert main(["dataset", *args]) == code
    told = capsys.readouterr()
    assert told.out == ""
    assert [line.split(":")[0].strip() for line in told.err.splitlines()[-4:]] == [
        "where",
        "value",
        "cause",
        "try",
    ]
    return told.err


def test_a_design_file_becomes_a_data_set(mine, tmp_path, capsys):
    out = tmp_path / "deep" / "data"
    assert main(["dataset", mine, "--out", str(out)]) == 0
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err == f"300 rows (300 converged), certificate {ID}: {out}\n"
    found = load(out)
    assert found.card["preset"] == "mine" and len(found) == 300
    assert main(["dataset", mine, "--out", str(out), "--json"]) == 0  # again: it is there
    told = capsys.readouterr()
    assert json.loads(told.out) == {"folder": str(out), **found.card}


def test_count_and_seed_in_place_of_the_designs(mine, tmp_path, capsys):
    first, second = tmp_path / "first", tmp_path / "second"
    assert main(["dataset", mine, "--out", str(first), "--count", "5", "--seed", "3"]) == 0
    assert main(["dataset", mine, "--out", str(second), "--count", "5"]) == 0
    assert (load(first).card["rows"], load(first).card["seed"], load(second).card["seed"]) == (5, 3, 0)
    assert (load(first).moments != load(second).moments).any()
    assert "1520" in refused(capsys, "--preset", "paper", "--count", "5", "--out", str(tmp_path / "third"))


def test_shards_from_the_command_line(mine, tmp_path, capsys):
    folders = [str(tmp_path / str(i)) for i in (1, 2)]
    for i, folder in enumerate(folders):
        assert main(["dataset", mine, "--out", folder, "--shard", f"{i + 1}/2", "--json"]) == 0
    told = capsys.readouterr().out.splitlines()
    assert '"shard": "1/2",' in "".join(told)
    out, straight = str(tmp_path / "out"), str(tmp_path / "straight")
    assert main(["dataset", "--merge", folders[0], "--merge", folders[1], "--out", out]) == 0
    assert main(["dataset", mine, "--out", straight]) == 0
    for name in ("data.npz", "card.json"):
        assert Path(out, name).read_bytes() == Path(straight, name).read_bytes()
    assert "blocks 1 of 3 are not there" in refused(
        capsys, "--merge", folders[0], "--out", str(tmp_path / "half")
    )


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (["--preset", "papr"], 'did you mean "paper"'),
        (["nowhere.toml"], "cannot be read"),
        (["MINE", "--preset", "paper"], "two designs"),
        (["--scheduler", "tcp://a:1", "--workers", "2"], "its own workers"),
        (["MINE", "--merge", "somewhere"], "the shards know their design"),
        (["--merge", "somewhere", "--shard", "1/2"], "the shards know their design"),
        (["MINE", "--shard", "3/2"], "no such shard"),
        (["--workers", "0"], "workers"),
        (["MINE", "--count", "0"], "count is out of range"),
    ],
)
def test_wrong_input(mine, tmp_path, capsys, args, words):
    out = tmp_path / "out"
    given = [mine if arg == "MINE" else arg for arg in args]
    assert words in refused(capsys, *given, "--out", str(out))
    assert not out.exists()


def test_a_folder_that_cannot_be_one(mine, tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert "The output folder cannot be used" in refused(capsys, mine, "--out", str(tmp_path / "file"))


def test_the_gate_closes_with_code_4(mine, tmp_path, capsys, monkeypatch):
    out = tmp_path / "out"
    monkeypatch.setattr(gate, "verify", valid({"loads": ["torsion"]}))
    told = refused(capsys, mine, "--out", str(out), code=4)
    assert "row 0: rod 'rod': no case that passed has 3333, enhanced, saint-venant-kirchhoff, bending" in told
    assert not (out / "data.npz").exists()
    monkeypatch.setattr(gate, "verify", stale)
    told = refused(capsys, mine, "--out", str(out), code=4)
    assert "ancf/energy.py changed" in told
    assert main(["dataset", mine, "--out", str(out), "--shard", "1/2", "--allow-unvalidated"]) == 0
    capsys.readouterr()
    assert refused(capsys, "--merge", str(out), "--out", str(tmp_path / "other"), code=4)
    other = str(tmp_path / "allowed")
    assert main(["dataset", mine, "--out", other, "--allow-unvalidated", "--json"]) == 0
    told = capsys.readouterr()
    assert json.loads(told.out)["certificate"] == "UNVALIDATED" and "UNVALIDATED" in told.err


def test_an_interruption_says_what_is_kept(mine, tmp_path, capsys, monkeypatch):
    out, solve = tmp_path / "out", sweep.solve

    def interrupted(block):
        if block.number == 1:
            raise KeyboardInterrupt
        return solve(block)

    with monkeypatch.context() as patch:
        patch.setattr(sweep, "solve", interrupted)
        assert main(["dataset", mine, "--out", str(out)]) == 130
    assert f"What is finished is kept in {out}" in capsys.readouterr().err
    assert [path.name for path in (out / "blocks").glob("*.npz")] == ["000000.npz"]
    assert main(["dataset", mine, "--out", str(out)]) == 0


def test_without_pyarrow_the_extra_is_named(mine, tmp_path, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    out = tmp_path / "out"
    assert "pip install 'ancf[parquet]'" in refused(capsys, mine, "--out", str(out), "--parquet")
    assert not out.exists()


def test_parquet_beside_the_arrays(mine, tmp_path):
    pytest.importorskip("pyarrow")
    out = tmp_path / "out"
    assert main(["dataset", mine, "--out", str(out), "--parquet"]) == 0
    assert (parquet.read(out / parquet.TABLE).pose == load(out).pose).all()


def test_without_distributed_the_extra_is_named(mine, tmp_path, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    told = refused(capsys, mine, "--out", str(tmp_path / "out"), "--scheduler", "tcp://127.0.0.1:1")
    assert "pip install 'ancf[cluster]'" in told


def test_it_starts_light():
    """The command is found and helped with nothing heavy loaded; one thread for the linear algebra."""
    code = (
        "import sys, surrogate.cli;"
        "print([m for m in ('numpy', 'scipy', 'torch', 'distributed', 'pyarrow') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


def test_the_command_in_a_process_of_its_own(mine, tmp_path):
    """With the shipped certificate, stale or not: data, or code 4 and the way around."""
    command = [
        sys.executable,
        "-m",
        "ancf.cli",
        "dataset",
        mine,
        "--count",
        "8",
        "--out",
        str(tmp_path / "out"),
    ]
    env = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
    done = subprocess.run(command, capture_output=True, text=True, env=env)
    assert done.returncode == 4 and "Traceback" not in done.stderr  # 6 elements are fewer than any case has
    done = subprocess.run([*command, "--allow-unvalidated"], capture_output=True, text=True, env=env)
    assert done.returncode == 0, done.stderr
    assert load(tmp_path / "out").card["certificate"] == "UNVALIDATED"


@pytest.mark.parametrize("path", sorted(DESIGNS.glob("*.toml")), ids=lambda path: path.stem)
def test_examples_of_designs(path, tmp_path):
    """Scenes without a closed form: follower moments, a tip force, gravity, tendons, neo-Hookean rubber."""
    out = tmp_path / "out"
    assert main(["dataset", str(path), "--count", "4", "--out", str(out), "--allow-unvalidated"]) == 0
    assert load(out).card["rows_by_status"] == {"converged": 4}

"""The README tells the truth: its files exist, its scene is the example, its Python runs."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import ancf

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", TEXT, re.DOTALL)


def test_named_files_exist():
    named = set(re.findall(r"`((?:tests|ancf|reference|validation|surrogate|examples)/[^`* ]*)`", TEXT))
    assert len(named) > 15
    assert [name for name in sorted(named) if not (ROOT / name).exists()] == []


def test_scene_is_the_example():
    shown = tomllib.loads(blocks("toml")[0])
    stored = tomllib.loads((ROOT / "examples/quarter-circle.toml").read_text(encoding="utf-8"))
    assert {key: stored[key] for key in shown} == shown


def test_python_runs(monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    solve, sweep, check = blocks("python")
    exec(compile(solve, "README.md", "exec"), {})
    assert "0.25457" in capsys.readouterr().out
    exec(compile(sweep, "README.md", "exec"), {})
    assert capsys.readouterr().out.startswith("(1520, 3, 4)\n")
    exec(compile(check, "README.md", "exec"), {})
    # The shipped certificate is of this code: `ancf validate --full --ship` after an edit of the solver.
    assert capsys.readouterr().out == "True []\n[]\n"


def test_tip_is_the_one_quoted():
    tip = ancf.solve(ancf.load_scene(ROOT / "examples/quarter-circle.toml")).tip().position
    quoted = re.search(r"the solver finds \(([\d.]+), ([\d.]+), 0\) m", TEXT)
    assert quoted is not None
    assert [f"{value:.5f}" for value in tip[:2]] == list(quoted.groups())

"""`report.json`: schema, no NaN, whole or not at all; exit codes and messages of the commands."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import pytest
from typer.testing import CliRunner

from validation import cli, runner
from validation.criteria import Verdict
from validation.problems import CaseResult
from validation.record import as_dict, write_json, write_text


@pytest.fixture(scope="module")
def small_run():
    return runner.run(wanted=("TO-circle-3333", "TO-square-3333", "HX-3333-12"))


def test_the_schema(small_run):
    data = as_dict(small_run)
    assert data["schema"] == 1
    assert data["verdict"] == "PARTIAL"  # three cases are not the validation
    assert data["complete"] is False
    assert data["certificate"] is None
    assert [case["verdict"] for case in data["cases"]] == ["PASS", "PASS", "KNOWN LIMIT"]
    assert [case["id"] for case in data["cases"]] == ["HX-3333-12", "TO-circle-3333", "TO-square-3333"]
    check = data["cases"][0]["checks"][0]
    assert set(check) >= {"quantity", "observed", "limit", "unit", "margin", "verdict", "kind", "reason"}
    assert check["margin"] == pytest.approx(check["limit"] / check["observed"])
    assert data["cases"][0]["reference"]["independence"] == "closed form"
    assert {"numpy", "python", "ancf"} <= set(data["versions"])
    assert "threads" in data["environment"]


def test_no_number_is_nan(small_run, tmp_path):
    broken = replace(small_run, seconds={"total": math.nan, "cases": math.inf})
    text = write_json(broken, tmp_path).read_text()

    def refuse(name: str):
        raise AssertionError(f"{name} in report.json")

    assert json.loads(text, parse_constant=refuse)["seconds"] == {"total": None, "cases": None}


def test_a_failed_case_fails_the_run(small_run):
    bad = replace(small_run.cases[0], verdict=Verdict.FAIL)
    run = replace(small_run, cases=[bad, *small_run.cases[1:]])
    assert as_dict(run)["verdict"] == "FAIL"
    assert as_dict(run)["blocking"] == ["case HX-3333-12"]


def test_a_case_that_is_not_required_does_not(small_run):
    first = small_run.cases[0]
    optional = replace(first, verdict=Verdict.FAIL, case=replace(first.case, required=False))
    assert replace(small_run, cases=[optional, *small_run.cases[1:]]).verdict[0] is Verdict.PASS


def test_a_required_case_that_was_skipped_fails_the_run(small_run):
    run = replace(small_run, cases=small_run.cases[1:])
    assert run.verdict == (Verdict.FAIL, ["required case HX-3333-12 was not run"])


def test_no_case_at_all_fails_the_run(small_run):
    run = replace(small_run, cases=[], expected=[])
    assert run.verdict == (Verdict.FAIL, ["no case was run"])


def test_an_empty_part_fails_the_run(small_run):
    run = replace(small_run, parts=("cases", "convergence"))
    assert run.verdict[1] == ["required case part convergence was not run"]


def test_a_broken_part_fails_the_run_and_the_others_go_on(monkeypatch):
    def broken(full):
        raise ZeroDivisionError("no studies")

    refused = next(case for case in runner.hard_cases.hard_cases() if case.expected == ("refused",))
    monkeypatch.setattr(runner.convergence, "studies", broken)
    monkeypatch.setattr(runner.hard_cases, "hard_cases", lambda: (refused,))
    record = runner.run(parts=("convergence", "hard cases"))
    assert record.failed_parts == {"convergence": "ZeroDivisionError: no studies"}
    assert "part convergence" in record.blocking
    assert record.hard_cases


def test_writing_leaves_nothing_half(tmp_path):
    target = write_text(tmp_path / "a.txt", "old")
    with pytest.raises(TypeError):
        write_text(target, 5)  # type: ignore[arg-type]
    assert target.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["a.txt"]


@pytest.fixture
def command():
    import typer

    app = typer.Typer()
    app.command()(cli.validate)
    app.command()(cli.report)
    return lambda *words: CliRunner().invoke(app, list(words))


def test_an_output_folder_that_is_a_file_is_refused(command, tmp_path):
    file = tmp_path / "out"
    file.write_text("mine")
    for out in (file, file / "deeper"):
        result = command("validate", "--out", str(out))
        assert result.exit_code == 2
        assert "The output folder is a file." in result.stderr
        for part in ("where:", "value:", "cause:", "try:"):
            assert part in result.stderr
    assert file.read_text() == "mine"


def test_contradicting_options_and_unknown_cases_are_refused(command, tmp_path):
    result = command("report", "--quick", "--full", "--out", str(tmp_path / "r"))
    assert (result.exit_code, (tmp_path / "r").exists()) == (2, False)
    result = command("validate", "--case", "HX-3333-21", "--out", str(tmp_path / "r"))
    assert (result.exit_code, (tmp_path / "r").exists()) == (2, False)
    assert "'HX-3333-24'" in result.stderr  # the nearest name


def test_one_case_by_name(command, tmp_path):
    result = command("validate", "--case", "TO-circle-3333", "--out", str(tmp_path / "new" / "r"))
    assert result.exit_code == 0
    data = json.loads((tmp_path / "new" / "r" / "report.json").read_text())
    assert [case["id"] for case in data["cases"]] == ["TO-circle-3333"]


def test_exit_code_5_when_a_check_fails(command, tmp_path, monkeypatch):
    def failing(case):
        return CaseResult(case, Verdict.FAIL, [], None, 0.0, "on purpose")

    monkeypatch.setattr(runner, "run_case", failing)
    result = command("validate", "--case", "TO-circle-3333", "--out", str(tmp_path))
    assert result.exit_code == 5
    assert json.loads((tmp_path / "report.json").read_text())["verdict"] == "FAIL"  # still written


def test_the_commands_are_light_at_import():
    import subprocess
    import sys

    heavy = "numpy scipy matplotlib jinja2 skfem rich.progress"
    code = f"import validation.cli, sys; print([m for m in {heavy.split()!r} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"

"""An interrupted full run goes on where it stopped; the journal of other code is named and discarded."""

from __future__ import annotations

import json
import math
from dataclasses import fields, replace

import numpy as np
import pytest
from typer.testing import CliRunner

from validation import cli, convergence, hard_cases, property_runs, runner
from validation.cases import load_cases
from validation.cost.points import CostPoint
from validation.cost.run import FamilyCost, Floor
from validation.criteria import Limit, Verdict, judge
from validation.hard_cases import HardCase, run_hard_case
from validation.journal import FILE, Journal, StoredOutcome, keep, revive
from validation.locking import LockingPoint, SlendernessRow
from validation.outcome import Outcome, Row
from validation.problems import CaseResult, run_case as real_run_case

IDS = ("TO-circle-3333", "HX-3333-12", "MO")
KEY = {"ancf/energy.py": "1", "versions": "2"}


@pytest.fixture
def three_cases(monkeypatch):
    """A full run has these three cases only; the list gathers those that were really run."""
    monkeypatch.setattr(runner, "all_cases", lambda: [c for c in load_cases() if c.id in IDS])
    ran = []

    def run_case(case):
        ran.append(case.id)
        return real_run_case(case)

    monkeypatch.setattr(runner, "run_case", run_case)
    return ran


def stop_at(monkeypatch, position):
    """Ctrl-C while the case at that position is in hand."""
    go_on, calls = runner.run_case, []

    def run_case(case):
        calls.append(case.id)
        if len(calls) > position:
            raise KeyboardInterrupt
        return go_on(case)

    monkeypatch.setattr(runner, "run_case", run_case)


def full(folder, **options):
    return runner.run("full", parts=("cases",), folder=folder, **options)


@pytest.mark.parametrize("position", [0, 1, 2])
def test_at_most_the_case_in_hand_is_lost(three_cases, tmp_path, monkeypatch, position):
    with monkeypatch.context() as patch:
        stop_at(patch, position)
        with pytest.raises(KeyboardInterrupt):
            full(tmp_path)
    order = [case.id for case in load_cases() if case.id in IDS]
    assert three_cases == order[:position]
    record = full(tmp_path)
    assert three_cases == order  # each exactly once
    assert [r.case.id for r in record.cases] == order
    assert [bool(record.notices), (tmp_path / FILE).exists()] == [position > 0, False]


def test_what_is_taken_from_the_journal_is_what_was_found(three_cases, tmp_path, monkeypatch):
    whole = full(tmp_path)
    with monkeypatch.context() as patch:
        stop_at(patch, 2)
        with pytest.raises(KeyboardInterrupt):
            full(tmp_path)
    resumed = full(tmp_path)
    for a, b in zip(whole.cases, resumed.cases, strict=True):
        assert (a.case.id, a.verdict, a.findings, a.reason, a.warnings) == (
            b.case.id, b.verdict, b.findings, b.reason, b.warnings
        )  # fmt: skip
        assert a.outcome is not None and b.outcome is not None
        assert (a.outcome.rows, a.outcome.notes) == (b.outcome.rows, b.outcome.notes)
        assert (a.outcome.solution is None) == (b.outcome.solution is None)
    assert resumed.regimes == whole.regimes and len(whole.regimes["HX-3333-12"]) == 1
    stored, fresh = resumed.cases[0].outcome, whole.cases[0].outcome
    assert isinstance(stored, StoredOutcome)
    assert stored.solution is not None and fresh is not None and fresh.solution is not None
    assert np.array_equal(stored.solution.q, fresh.solution.q)  # solved again for the drawing: the same


def test_a_crashed_case_is_tried_again(three_cases, tmp_path, monkeypatch):
    def crash(case):
        return CaseResult(case, Verdict.FAIL, [], None, 0.0, "MemoryError: ")

    with monkeypatch.context() as patch:
        patch.setattr(runner, "run_case", crash)
        stop_at(patch, 2)
        with pytest.raises(KeyboardInterrupt):
            full(tmp_path)
    assert len(full(tmp_path).cases) == 3
    assert len(three_cases) == 3


def test_fresh_and_quick_runs_take_nothing_from_it(three_cases, tmp_path, monkeypatch):
    stop_at(monkeypatch, 2)
    with pytest.raises(KeyboardInterrupt):
        full(tmp_path)
    monkeypatch.undo()
    monkeypatch.setattr(runner, "all_cases", lambda: [c for c in load_cases() if c.id == "MO"])
    before = (tmp_path / FILE).read_bytes()
    assert runner.run("quick", parts=("cases",), folder=tmp_path).notices == []
    assert (tmp_path / FILE).read_bytes() == before  # and a quick run leaves it alone
    assert full(tmp_path, fresh=True).notices == []


def test_the_journal_of_other_code_is_named_and_discarded(tmp_path):
    Journal(tmp_path, KEY).add("cases", "A", [1])
    again = Journal(tmp_path, {**KEY, "ancf/energy.py": "9"})
    assert again.found == {}
    assert "is discarded: ancf/energy.py changed" in again.notices[0]
    assert Journal(tmp_path, KEY).found == {}  # it is gone, not hidden


def test_lines_are_on_the_disk_at_once_and_added_to_later(tmp_path):
    first = Journal(tmp_path, KEY)
    first.add("cases", "A", [1.5, math.inf], seconds=2.0)
    second = Journal(tmp_path, KEY)
    assert second.found["cases", "A"]["results"] == [1.5, math.inf]
    second.add("cases", "B", [2])
    assert list(Journal(tmp_path, KEY).found) == [("cases", "A"), ("cases", "B")]
    first.remove()
    assert not (tmp_path / FILE).exists()


@pytest.mark.parametrize("damage", ["cut", "flip", "bytes"])
def test_a_damaged_line_is_named_and_run_again(tmp_path, damage):
    journal = Journal(tmp_path, KEY)
    for name in "AB":
        journal.add("cases", name, ["PASS", name])
    data = journal.path.read_bytes()
    if damage == "cut":  # killed while it wrote
        data = data[:-9]
    elif damage == "flip":
        data = data.replace(b'["PASS", "B"]', b'["FAIL", "B"]')
    else:
        data = data[:-9] + b"\xff\xfe" + data[-7:]
    journal.path.write_bytes(data)
    again = Journal(tmp_path, KEY)
    assert list(again.found) == [("cases", "A")]
    assert "1 damaged line left out" in again.notices[0]
    again.add("cases", "B", [3])
    assert list(Journal(tmp_path, KEY).found) == [("cases", "A"), ("cases", "B")]


@pytest.mark.parametrize("content", [b"", b"{}", b"[1]\n", b"\xff\n", b'{"key": 5}\n'])
def test_a_file_that_is_no_journal_is_discarded(tmp_path, content):
    (tmp_path / FILE).write_bytes(content)
    journal = Journal(tmp_path, KEY)
    assert (journal.found, len(journal.notices)) == ({}, 1)


def through(record, kind, declared=None):
    return revive(kind, json.loads(json.dumps(keep(record))), declared or {})


def test_every_kind_of_result_comes_back():
    limit = Limit("q*", 0.1, "L", "because", documented=0.3)
    finding = judge(limit, "q1", np.float64(0.3), math.inf)
    study = convergence.studies()[0]
    order = convergence.StudyResult(study, [1.0, 0.5], 2.0, [finding], 1.0)
    assert through(order, convergence.StudyResult, {convergence.Study: study}) == order
    hard = run_hard_case(next(c for c in hard_cases.hard_cases() if c.name == "no load at all"))
    assert through(hard, hard_cases.HardResult, {HardCase: hard.case}) == hard
    check = property_runs.PropertyResult("a", "b", 1.0, "-", 3, finding, (1, 2, 3), 0.5)
    assert through(check, property_runs.PropertyResult) == check
    point = LockingPoint("3333", "enhanced", 0.3, np.float64(1.0), 1.0)
    assert through(point, LockingPoint) == point
    row = SlendernessRow(20, 1, [0.1, 0.2], [None, 0.2])
    assert through(row, SlendernessRow) == row
    point = CostPoint("3333", "beam", "enhanced", 1, "1 element", "analytic", "auto", "converged")
    floor = Floor("3333", "enhanced", 1e-3, 1e-6, None)
    family = FamilyCost(
        "a", "b", "c", "rod", "d", 1e-9, [None, 0.0], None, [point], [floor], ["omitted"], 1.0
    )
    assert through(family, FamilyCost) == family
    case = load_cases()[0]
    outcome = Outcome({"q1": 0.3}, [Row("a", 1.0, None, "m")], None, {"rod": []}, {"q1": 0.1}, ["note"])
    found = through(CaseResult(case, Verdict.WARN, [finding], outcome, 1.0, "r", ["w"]), CaseResult,
                    {type(case): case})  # fmt: skip
    assert found.case is case and found.findings == [finding] and found.verdict is Verdict.WARN
    assert found.outcome.solution is None and found.outcome.rows == outcome.rows
    assert keep(found) == keep(replace(found))


def test_a_stored_outcome_has_every_field_of_an_outcome():
    """A field added to `Outcome` has to be kept as well."""
    names = {f.name for f in fields(Outcome)} - {"solution"}
    assert {f.name for f in fields(StoredOutcome)} - {"solved"} == names
    assert set(keep(Outcome({}, []))) - {"solved"} == names


def test_a_stored_outcome_is_kept_again_as_it_was():
    stored = StoredOutcome({"q": 1.0}, [], {"rod": []}, {}, [], solved=True)
    assert keep(stored)["solved"] is True
    assert through(stored, Outcome) == stored


@pytest.fixture
def command():
    import typer

    app = typer.Typer()
    app.command()(cli.validate)
    app.command()(cli.report)
    return lambda *words: CliRunner().invoke(app, list(words))


def test_ctrl_c_says_that_nothing_is_lost(command, three_cases, tmp_path, monkeypatch):
    stop_at(monkeypatch, 1)
    result = command("validate", "--full", "--out", str(tmp_path))
    assert result.exit_code == 130
    assert "the same command goes on from there" in result.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == [FILE]


def test_shipping_needs_a_whole_full_run(command, tmp_path):
    for words in (["--ship"], ["--ship", "--full", "--case", "MO"]):
        result = command("validate", *words, "--out", str(tmp_path / "r"))
        assert (result.exit_code, (tmp_path / "r").exists()) == (2, False)
        assert "Only a whole full run can be shipped." in result.stderr


def passing(monkeypatch, reasons):
    """A full run that passed, and what the certificate's own check says of it."""
    from validation import certify

    def run(scope, progress, wanted, folder, fresh):
        record = runner.Run(scope, "2026-01-01 00:00 UTC", seconds={"total": 1.0})
        monkeypatch.setattr(runner.Run, "verdict", (Verdict.PASS, []))
        return record

    def build(record):
        return {"id": "abc"}

    monkeypatch.setattr(runner, "run", run)
    monkeypatch.setattr(certify.certificate, "build", build)
    monkeypatch.setattr(certify.certificate, "faults", lambda *_: reasons)


def test_a_full_run_prints_its_certificate(command, tmp_path, monkeypatch):
    passing(monkeypatch, [])
    result = command("validate", "--full", "--out", str(tmp_path))
    assert result.exit_code == 0
    assert f"written: {tmp_path / 'certificate.json'}" in result.stderr
    assert "certificate: abc (this run)" in result.stderr
    assert json.loads((tmp_path / "report.json").read_text())["certificate"] == "abc"


def test_exit_code_4_when_the_code_changed_meanwhile(command, tmp_path, monkeypatch):
    passing(monkeypatch, ["ancf/energy.py changed"])
    result = command("validate", "--full", "--out", str(tmp_path))
    assert result.exit_code == 4
    assert "ancf/energy.py changed" in result.stderr
    data = json.loads((tmp_path / "report.json").read_text())
    assert (data["certificate"], data["certificate_reasons"]) == (None, ["ancf/energy.py changed"])


def test_a_quick_run_names_what_is_wrong_with_the_shipped_one(command, tmp_path, monkeypatch):
    from validation import certificate

    (tmp_path / "shipped.json").write_text("{")
    monkeypatch.setattr(certificate, "SHIPPED", tmp_path / "shipped.json")
    monkeypatch.setattr(runner, "PARTS", ("cases",))  # a whole run of one part
    result = command("validate", "--case", "MO", "--out", str(tmp_path))
    assert result.exit_code == 0
    assert "the shipped one does not hold" in result.stderr
    assert "it is not JSON" in result.stderr

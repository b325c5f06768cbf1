"""The study of the surrogate: numbers asked for, what a model is worth, the chapter of the report."""

from __future__ import annotations

import copy
import json
import math
import warnings
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from ancf.cli import main
from surrogate.arm import paper_arm
from surrogate.asked import asked
from surrogate.conformal import ErrorRadius, calibration
from surrogate.evaluate import LeakWarning
from surrogate.problem import box_design, solved_problem
from surrogate.worth import sentences
from validation import runner
from validation.report import page
from validation.report.surrogate_study import study_chapter

pytest.importorskip("torch", reason="torch is not installed (extra `surrogate`)")
pytest.importorskip("matplotlib")
pytest.importorskip("jinja2")

ARM = paper_arm(elements=4, element="3333")
BOX = np.outer(np.ones(3), [-0.02, 0.02])  # N m


@pytest.fixture(scope="module")
def problem():
    return solved_problem(ARM, box_design(BOX, 128, 0), {}, "small")


@pytest.fixture(scope="module")
def folder(problem, tmp_path_factory):
    """A study of a small problem with trainings that end at once, in the folder of a report."""
    import surrogate.compare
    import surrogate.study
    import surrogate.worth
    from surrogate.reproduce import reproduce
    from surrogate.study import RECORD, study

    place = tmp_path_factory.mktemp("report") / "surrogate"
    place.mkdir()

    def small(measure):
        return lambda given, *rest: measure(replace(problem, name=given.name), *rest)

    with pytest.MonkeyPatch.context() as patch, warnings.catch_warnings():
        warnings.simplefilter("ignore", LeakWarning)
        for module, name, few in (
            (surrogate.compare, "ROWS", 8), (surrogate.compare, "COVERED", 64), (surrogate.worth, "POSES", 3),
        ):  # fmt: skip
            patch.setattr(module, name, few)
        patch.setattr(surrogate.compare, "reachability", lambda given: 1.0)
        patch.setattr(surrogate.study, "compare", small(surrogate.compare.compare))
        patch.setattr(surrogate.study, "compare_errors", small(surrogate.compare.compare_errors))
        patch.setattr(
            surrogate.study, "reproduce", lambda given, folder, **_: reproduce(problem, folder, 0, 2, 1)
        )
        record = study(place, [0, 1], 1, count=64, allow_unvalidated=True)
    (place / RECORD).write_text(json.dumps(record, allow_nan=False))
    return place.parent


@pytest.fixture
def record(folder):
    return json.loads((folder / "surrogate" / "study.json").read_text())


def test_a_study_holds_every_model_and_figure(record, folder):
    kinds = [m["kind"] for m in record["comparison"]["sobol"]["models"]]
    assert set(kinds) == {
        "closed form", "rbf", "polynomial, 400 solves", "polynomial", "log mlp", "cnn, decayed rate", "cnn",
        "mlp", "equivariant",
    }  # fmt: skip
    assert set(record["data"]) == {"paper", "sobol"} and record["data"]["paper"]["rows"] == 1520
    names = sorted(path.name for path in (folder / "surrogate").iterdir())
    assert names == sorted([*(f"fig{k}.png" for k in range(4, 12)), "study.json"])  # the data are not kept


def change(record, path, value):
    place: Any = record
    for key in path[:-1]:  # a model of a list is named by its kind
        named = isinstance(key, str) and not isinstance(place, dict)
        place = next(entry for entry in place if entry["kind"] == key) if named else place[key]
    place[path[-1]] = value


SOBOL = ("comparison", "sobol")
OFF = ("sets", "off_grid", "tip_percent")
LIMITS = [  # row, what decides it, a value just inside, one just outside (the limits of the issue)
    ("MSE", ("reproduction", "table_1", "models", 0, "ratio"), 2.99, 3.01),
    ("MSE", ("reproduction", "table_1", "models", 0, "ratio"), 0.34, 0.33),
    ("parameters", ("reproduction", "table_1", "models", 1, "size"), 187, 188),
    ("order", ("reproduction", "table_1", "order"), "5 < 1 < 4 < 3 < 2", "5 < 4 < 1 < 3 < 2"),
    ("R^2", ("reproduction", "main_cnn", "test_r2", 0), 0.9951, 0.9949),
    ("off the grid", (*SOBOL, "models", "cnn", *OFF, "mean", "mean"), 2.99, 3.01),
    (
        "trajectory",
        (*SOBOL, "models", "cnn", "sets", "trajectory", "tip_percent", "mean", "mean"),
        2.49,
        2.51,
    ),
    ("Best network", (*SOBOL, "models", "equivariant", *OFF, "mean", "mean"), 0.029, 0.031),
    ("Best network", (*SOBOL, "models", "equivariant", *OFF, "p95", "mean"), 0.099, 0.101),
    ("Best network", (*SOBOL, "models", "equivariant", *OFF, "max", "mean"), 0.49, 0.51),
    ("400 solves", (*SOBOL, "models", "polynomial, 400 solves", *OFF, "mean", "mean"), 0.0099, 0.0101),
    ("One Gauss-Newton", (*SOBOL, "models", "equivariant", "gauss_newton", 0, "max_percent"), 0.9e-3, 1.1e-3),
    ("Two steps", (*SOBOL, "models", "equivariant", "gauss_newton", 1, "max_percent"), 0.9e-8, 1.1e-8),
    ("Two steps", (*SOBOL, "models", "equivariant", "gauss_newton", 1, "solved"), 1.0, 0.999),
    ("AUROC", (*SOBOL, "auroc"), 0.991, 0.989),
    ("Coverage", (*SOBOL, "models", "rbf", "coverage", "position"), 0.931, 0.929),
    ("Coverage", (*SOBOL, "models", "cnn", "coverage", "moment"), 0.969, 0.971),
    ("Leak", ("comparison", "paper", "models", "cnn", "leak"), "warned", ""),
]


@pytest.fixture
def good(record):
    """The record with every number inside its limit."""
    for _, path, inside, _ in LIMITS:
        change(record, path, inside)
    for row in record["reproduction"]["table_1"]["models"]:
        row["ratio"] = 1.0
    record["reproduction"]["main_cnn"]["test_r2"] = [0.999] * 3
    for model in record["comparison"]["sobol"]["models"]:
        model["coverage"].update(position=0.95, moment=0.95)
    return record


@pytest.mark.parametrize(("row", "path", "inside", "outside"), LIMITS)
def test_each_number_asked_for_is_judged(good, row, path, inside, outside):
    for value, met in ((inside, True), (outside, False)):
        tried = copy.deepcopy(good)
        change(tried, path, value)
        verdicts = {r["what"]: r["met"] for r in asked(tried) if r["met"] is not None}
        assert all(verdicts.values()) is met
        assert all(row in what for what, held in verdicts.items() if not held)
    assert sum(r["met"] is None for r in asked(good)) == 4  # times are not judged


def test_the_chapter_shows_the_study(folder, record):
    run = runner.Run("quick", "now", certificate=record["certificate"])
    run.seconds["total"] = 0.0
    html = page.render(run, folder)
    chapter = html[html.index('<section id="surrogate">') :]
    chapter = chapter[: chapter.index("</section>")]
    assert chapter.count("data:image/png;base64,") == 8
    for text in (
        "Asked and found", "When a surrogate is worth having", "All models in closed loop",
        "The paper's split leaks",
        "Table 1 beside the print", "8.17", "log mlp", "AUROC", "UNVALIDATED", "sin²φ", "not judged",
    ):  # fmt: skip
        assert text in chapter, text
    assert 'id="surrogate-worth"' in chapter and 'href="#surrogate"' in html


@pytest.mark.parametrize(
    ("stamp", "certificate", "state"),
    [("a" * 64, "a" * 64, "PASS"), ("a" * 64, "b" * 64, "WARN"), ("a" * 64, None, "WARN"),
     ("UNVALIDATED", "a" * 64, "FAIL"), ("UNVALIDATED", None, "FAIL")],
)  # fmt: skip
def test_the_state_of_the_gate_is_judged(folder, record, tmp_path, stamp, certificate, state):
    record["certificate"] = stamp
    for data in record["data"].values():
        data["certificate"] = stamp
    assert _chapter(folder, record, tmp_path, certificate)["gate"]["state"] == state


def test_unvalidated_rows_in_one_data_set_are_seen(folder, record, tmp_path):
    record["certificate"] = record["data"]["sobol"]["certificate"] = "a" * 64
    record["data"]["paper"]["certificate"] = "UNVALIDATED"
    assert _chapter(folder, record, tmp_path, "a" * 64)["gate"]["state"] == "FAIL"


def _chapter(folder, record, tmp_path, certificate):
    place = tmp_path / "surrogate"
    place.mkdir()
    for picture in (folder / "surrogate").glob("*.png"):
        (place / picture.name).symlink_to(picture)
    (place / "study.json").write_text(json.dumps(record))
    return study_chapter(tmp_path, certificate)


@pytest.mark.parametrize(
    ("content", "word"),
    [
        (None, "Not in this run"),
        ("{", "cannot be read"),
        ('{"schema": 2}', "another schema"),
        ("[]", "another schema"),
        ('{"schema": 1}', "KeyError"),
        ('{"schema": 1, "reproduction": {"figures": [{"name": "fig4"}]}}', "fig4.png"),
    ],
)
def test_a_study_that_cannot_be_shown_is_named(tmp_path, content, word):
    (tmp_path / "surrogate").mkdir()
    if content is not None:
        (tmp_path / "surrogate" / "study.json").write_text(content)
    assert word in study_chapter(tmp_path, None)["missing"]


def test_a_model_that_saves_nothing_never_pays(record):
    worth = record["comparison"]["sobol"]["worth"]
    found = {**worth, "pays_after": {"unrefined": 1234.0, "as a guess": None}}
    text = " ".join(sentences(found))
    assert "after 1,234 poses" in text and "first guesses never" in text
    saved = worth["solves"]["closed form"] - worth["solves"]["best"]
    assert worth["saved_solves"]["closed form"] == pytest.approx(saved)
    cost = 1e-3 * worth["data_solves"] * worth["solve_in_batch_ms"] + worth["training_seconds"]
    per_pose = 1e-3 * (worth["inverse_ms"]["closed form"] - worth["model_ms"])
    assert worth["pays_after"]["unrefined"] == pytest.approx(cost / per_pose)
    assert worth["data_solves"] == 128 + 1024


def test_calibration_rows_are_new_and_fill_the_box(problem):
    rows = calibration(problem)
    assert len(rows) == 1024 and (np.abs(rows.moments) <= 0.02).all()
    np.testing.assert_allclose(rows.moments.std(axis=0), 0.02 / math.sqrt(3.0), rtol=0.01)  # uniform
    assert not {m.tobytes() for m in rows.moments} & {m.tobytes() for m in problem.all.moments}


@pytest.mark.parametrize("rows", [228, 1024])
def test_the_deviation_of_the_coverage_is_that_of_its_distribution(rows):
    """Vovk 2012: given the calibration rows, the coverage is Beta(k, n + 1 - k)."""
    from scipy.stats import beta

    k = math.ceil((rows + 1) * 0.95)
    assert ErrorRadius(0.95, rows, 1.0, 1.0).deviation == pytest.approx(beta(k, rows + 1 - k).std(), rel=0.05)


def test_the_share_of_the_published_order():
    """Two seeds a model: certain when apart, impossible when reversed, even when one seed in two swaps."""
    from surrogate.architecture import PUBLISHED_MSE, TABLE_1
    from surrogate.crossval import Table, TableRow, order

    assert order(PUBLISHED_MSE) == "5 < 1 < 4 < 3 < 2"  # table 1 of the paper

    def table(runs):
        rows = [
            TableRow(a, 0, mse, np.zeros((10, 1)), np.repeat(run, 5)[:, None], 1.0, np.ones(10), np.ones(10))
            for a, mse, run in zip(TABLE_1, PUBLISHED_MSE, runs, strict=True)
        ]
        return Table(rows, 1.0, 50, 2, 0.0, "")

    apart = [[4.0, 4.1], [8.0, 8.1], [7.0, 7.1], [5.0, 5.1], [1.0, 1.1]]
    assert table(apart).order_share() == 1.0 and table([r[::-1] for r in apart[::-1]]).order_share() == 0.0
    swapping = [*apart[:3], [3.0, 5.0], apart[4]]  # model 4 below model 1 with one of its seeds
    assert table(swapping).order_share(size=1) == pytest.approx(0.5, abs=0.02)
    np.testing.assert_allclose(table(apart).runs, apart)
    pairs = table(swapping).neighbours()
    assert [p["pair"] for p in pairs] == ["5 < 1", "1 < 4", "4 < 3", "3 < 2"]
    assert [p["share"] for p in pairs] == [1.0, 0.5, 1.0, 1.0]
    assert pairs[1]["published_gap"] == pytest.approx(4.54 / 4.19 - 1.0)
    assert pairs[1]["gap"] == pytest.approx(4.0 / 4.05 - 1.0)


def test_the_report_measures_in_a_process_of_its_own(tmp_path, monkeypatch, capsys):
    import subprocess

    import validation.cli

    commands = []

    def ran(command, **_):
        commands.append(command)
        return subprocess.CompletedProcess(command, 4)

    monkeypatch.setattr(subprocess, "run", ran)
    validation.cli._study(tmp_path)
    assert commands[0][1:] == ["-m", "ancf.cli", "study", "--out", str(tmp_path / "surrogate")]
    assert "exit code 4" in capsys.readouterr().err


def test_no_study_without_a_valid_certificate(tmp_path, monkeypatch, capsys):
    import surrogate.gate
    from validation.certificate import Verification

    stale = Verification(tmp_path / "certificate.json", None, ["ancf/energy.py was changed"])
    monkeypatch.setattr(surrogate.gate, "verify", lambda: stale)
    assert main(["study", "--out", str(tmp_path / "s"), "--seeds", "1", "--epochs", "1"]) == 4
    assert "ancf/energy.py was changed" in capsys.readouterr().err
    assert not list((tmp_path / "s").iterdir())
